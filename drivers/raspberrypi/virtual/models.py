"""Virtual pins in simulated time, and models of the hardware that connect them to the devices of a simulator."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

from gpiozero.pins.mock import MockFactory, MockPWMPin

from drivers.raspberrypi.buzzers import PinBuzzerDriver
from drivers.raspberrypi.cameras.capture import CameraDriver
from drivers.raspberrypi.contacts import ContactDriver
from drivers.raspberrypi.encoders import EncoderDriver, Pulses, Quadrature
from drivers.raspberrypi.gamepads import EventGamepadDriver
from drivers.raspberrypi.i2c import ChipDriver
from drivers.raspberrypi.lights import LightDriver
from drivers.raspberrypi.line_sensors import PinLineSensorDriver
from drivers.raspberrypi.motors.boards import HBridge, MotorDriver, PhaseEnable
from drivers.raspberrypi.pwm.motors import ChannelMotorDriver, HBridgeChannelDriver, PhaseChannelDriver
from drivers.raspberrypi.pwm.servos import ChannelServoDriver
from drivers.raspberrypi.pwm.settings import ChannelDriver
from drivers.raspberrypi.ranging.ultrasonic_driver import Ultrasonic, speed_of_sound
from drivers.raspberrypi.servos import FRAME_HZ, PinServoDriver, PulseDriver
from drivers.raspberrypi.virtual.pwm_chip import VirtualChannel, VirtualPwmChip
from robotcore.description import DeviceDescription
from robotcore.hal.clock import MIN_PHYSICS_RATE_HZ, Clock, SteppedClock
from robotcore.hal.kind import load_kind
from robotcore.hal.robot import Robot
from robotcore.hardware import DeviceBinding
from robotcore.hardware.motor_model import MotorModel
from robotcore.kinds.bumper import Bumper
from robotcore.kinds.button import Button
from robotcore.kinds.buzzer import Buzzer
from robotcore.kinds.encoder import Encoder, EncoderDescription
from robotcore.kinds.led import Led
from robotcore.kinds.line_sensor import THRESHOLD, LineSensor
from robotcore.kinds.motor import Motor, MotorDescription
from robotcore.kinds.range_sensor import RangeSensor
from robotcore.kinds.servo import Servo

PI_4B = "c03115"
"""The revision code of the simulated board, a Raspberry Pi 4B.

Source: https://www.raspberrypi.com/documentation/computers/raspberry-pi.html#raspberry-pi-revision-codes."""


class VirtualPin(MockPWMPin):  # type: ignore[misc]  # gpiozero has no types
    """A pin that is connected to a model of hardware. The model gets every change of an output, and sets an input.

    The duty is rounded down to whole percent, as with lgpio. Unlike gpiozero's mock pin, this pin stores no list of
    past levels.
    """

    _state: float

    def __init__(self, factory: Any, info: Any) -> None:
        self._listeners: list[Callable[[], object]] = []
        self._is_driven = False
        super().__init__(factory, info)

    def on_change(self, listener: Callable[[], object]) -> None:
        """Call ``listener`` after each change of the pin's level or duty."""
        self._listeners.append(listener)

    def drive(self, level: int, ticks: float | None = None) -> None:
        """Set the level of an input, 0 or 1.

        ticks: the time of the edge in seconds; by default the current time.
        """
        self._is_driven = True
        if self._function == "input" and self._change_state(bool(level)):
            if ticks is not None:
                self._last_change = ticks
            if self._when_changed and self._edges in ("both", "rising" if level else "falling"):
                self._call_when_changed()

    def drive_high(self) -> None:
        """Pull the pin up, unless a model drives the pin."""
        if not self._is_driven:
            super().drive_high()

    def drive_low(self) -> None:
        """Pull the pin down, unless a model drives the pin."""
        if not self._is_driven:
            super().drive_low()

    def clear_states(self) -> None:
        """Set the time of the last change to the current time."""
        self._last_change = self._factory.ticks()

    def set_duty(self, duty: float) -> None:
        """Set the duty of an output with PWM, from 0 to 1, without rounding."""
        super()._set_state(duty)

    def _set_state(self, value: float) -> None:
        super()._set_state(int(value * 100) / 100)

    def _change_state(self, value: float) -> bool:
        if self._state == value:
            return False
        self._state = value
        self._last_change = self._factory.ticks()
        for listener in self._listeners:
            listener()
        return True


class VirtualPins(MockFactory):  # type: ignore[misc]  # gpiozero has no types
    """A pin factory with a virtual pin for each GPIO. Its ticks are simulated time in seconds.

    >>> from gpiozero import LED
    >>> from robotcore.hal.clock import SteppedClock
    >>> with VirtualPins(SteppedClock(20.0, lambda steps: None)) as pins, LED(17, pin_factory=pins) as led:
    ...     led.on()
    ...     pins.pin(17).state
    1.0
    """

    def __init__(self, clock: Clock) -> None:
        super().__init__(revision=PI_4B, pin_class=VirtualPin)
        self._clock = clock
        self._chips: dict[tuple[int, int], VirtualPwmChip] = {}

    def open_i2c(self, bus: int, address: int) -> VirtualPwmChip:
        """Return the chip at an address of an I2C bus."""
        return self._chips.setdefault((bus, address), VirtualPwmChip())

    def ticks(self) -> float:
        """Return the simulated time in seconds."""
        return self._clock.now()


QUADRATURE = ((1, 1), (0, 1), (0, 0), (1, 0))
"""The levels of the channels (a, b) after each edge of a forward turn, on which channel a leads."""

SLOTS = ((0,), (1,))
"""The levels of the only channel of a slotted disc, which does not show the direction."""


class Disc:
    """An encoder disc that turns with a wheel, and sets the encoder's pins.

    encoder: the simulator's encoder, which gives the angle of the wheel.
    radians: the angle between two edges.
    levels: the levels of the pins after each edge of a forward turn.
    """

    def __init__(
        self, encoder: Encoder, radians: float, levels: Sequence[Sequence[int]], pins: Sequence[VirtualPin]
    ) -> None:
        self._encoder, self._radians = encoder, radians
        self._levels, self._pins = levels, pins
        self._edge = 0
        self._show()

    def update(self) -> None:
        """Show all edges since the last update."""
        target = round(self._encoder.read().angle / self._radians)
        step = 1 if target > self._edge else -1
        while self._edge != target:
            self._edge += step
            self._show()

    def _show(self) -> None:
        for pin, level in zip(self._pins, self._levels[self._edge % len(self._levels)], strict=True):
            pin.drive(level)


BURST_S = 450e-6
"""The time from the end of the trigger to the rise of the echo line, in seconds. It has a burst of eight cycles at
40 kHz, and a pause."""

SILENCE_S = 38e-3
"""The length of an HC-SR04's pulse if no echo returns, in seconds. Source: its data sheet."""


class VirtualEcho:
    """A model of an ultrasonic module, whose pulse follows from the distance that the simulator's sensor measures.

    The distance is read at the trigger. An edge is set in the first physics step after its exact time, but its tick is
    the exact time.

    speed_of_sound: the speed of sound in m/s.
    is_lost: called for each echo; returns whether the echo is lost, as a real one that glances off a wall.
    """

    def __init__(
        self,
        clock: Clock,
        sensor: RangeSensor,
        trigger: VirtualPin,
        echo: VirtualPin,
        speed_of_sound: float,
        is_lost: Callable[[], bool],
    ) -> None:
        self._clock, self._sensor = clock, sensor
        self._trigger, self._echo = trigger, echo
        self._speed, self._is_lost = speed_of_sound, is_lost
        self._is_busy = False
        echo.drive(0)
        trigger.on_change(self._on_trigger)

    def _on_trigger(self) -> None:
        if not (self._trigger.state or self._is_busy):
            self._is_busy = True
            self._send()

    def _send(self) -> None:
        rises = self._clock.now() + BURST_S
        distance = math.inf if self._is_lost() else self._sensor.read().distance
        falls = rises + (SILENCE_S if math.isinf(distance) else 2 * distance / self._speed)
        self._call_at(rises, partial(self._echo.drive, 1, rises))
        self._call_at(falls, partial(self._end, falls))

    def _end(self, at: float) -> None:
        self._is_busy = False
        self._echo.drive(0, at)

    def _call_at(self, at: float, edge: Callable[[], None]) -> None:
        if self._clock.now() == 0:  # drivers need a first sample, and no time passes until the robot is open
            edge()
        else:
            self._clock.call_at(at, edge)


def wire_motor(
    motor: Motor, model: MotorModel, pins: Sequence[VirtualPin | VirtualChannel], duty: Callable[..., float]
) -> None:
    """Connect a motor to the pins of its board, or to the channels of its chip.

    duty: returns the duty from -1 to 1 for the levels of the pins, such as `read_two_inputs`.
    """

    def turn() -> None:
        motor.set_velocity(model.velocity(duty(*(float(pin.state) for pin in pins))))

    for pin in pins:
        pin.on_change(turn)


def read_two_inputs(forward: float, backward: float, *gates: float) -> float:
    """Return the duty of an H-bridge with an input for each direction. Equal inputs brake the motor.

    gates: the levels of the inputs that enable the H-bridge, such as PWMA. Their duties scale the motor's duty.
    """
    return (forward - backward) * math.prod(gates)


def read_phase_and_enable(phase: float, enable: float) -> float:
    """Return the duty of a board with a direction input, which is high to turn backward."""
    return -enable if phase else enable


def connect_motor(driver: MotorDriver, motor: Motor, pins: VirtualPins) -> None:
    """Connect the simulator's motor to the pins of its driver."""
    match driver:
        case HBridge() as on:
            lines = (on.forward, on.backward, on.pwm, on.enable)
            wire_motor(motor, on.model, [pins.pin(line) for line in lines if line is not None], read_two_inputs)
        case PhaseEnable() as on:
            wire_motor(motor, on.model, [pins.pin(on.phase), pins.pin(on.enable)], read_phase_and_enable)


def wire_servo(
    servo: Servo, driver: PulseDriver, output: VirtualPin | VirtualChannel, frequency_hz: Callable[[], float]
) -> None:
    """Connect a servo to a pin or a channel. Without pulses it holds its angle.

    frequency_hz: returns the number of pulses in a second.
    """

    def turn() -> None:
        if output.state:
            least, greatest = driver.pulses
            share = (output.state / frequency_hz() - least) / (greatest - least)
            servo.set_angle(servo.min_angle + share * (servo.max_angle - servo.min_angle))

    output.on_change(turn)


def wire_indicator(indicator: Led | Buzzer, pins: Sequence[VirtualPin], active_high: bool = True) -> None:  # noqa: FBT001, FBT002
    """Connect a light to the pins of its colours, or to its only pin; or a buzzer to its pin."""

    def show() -> None:
        if isinstance(indicator, Buzzer):
            indicator.play(float(pins[0].frequency or 0.0) if pins[0].state else 0.0)
            return
        parts = [float(pin.state) if active_high else 1 - float(pin.state) for pin in pins]
        red, green, blue = parts if len(parts) > 1 else parts * 3
        indicator.set_colour(red, green, blue)

    for pin in pins:
        pin.on_change(show)
    show()


def connect_channels(driver: ChannelDriver, actuator: Motor | Servo, pins: VirtualPins) -> None:
    """Connect the simulator's motor or servo to the channels of its driver."""
    chip = pins.open_i2c(driver.bus, driver.address)
    match driver, actuator:
        case HBridgeChannelDriver() as on, Motor() as motor:
            inputs = [chip.channels[number] for number in (on.forward, on.backward, on.pwm) if number is not None]
            wire_motor(motor, on.model, inputs, read_two_inputs)
        case PhaseChannelDriver() as on, Motor() as motor:
            inputs = [pins.pin(on.phase), chip.channels[on.pwm]]
            sign = -1 if on.forward_is_high else 1
            wire_motor(motor, on.model, inputs, lambda phase, pwm: sign * read_phase_and_enable(phase, pwm))
        case ChannelServoDriver() as on, Servo() as servo:
            wire_servo(servo, on, chip.channels[on.channel], lambda: chip.frequency_hz)


def drive_outputs(row: LineSensor, outputs: Sequence[VirtualPin], active_high: bool) -> None:  # noqa: FBT001
    """Set the pins of a row of digital line sensors."""
    for output, darkness in zip(outputs, row.read().values, strict=True):
        output.drive((darkness > THRESHOLD) is active_high)


MODELLED_DRIVERS = (
    HBridge,
    PhaseEnable,
    ChannelDriver,
    Quadrature,
    Pulses,
    Ultrasonic,
    ContactDriver,
    LightDriver,
    PinBuzzerDriver,
    PinLineSensorDriver,
    PinServoDriver,
)
"""The drivers of the devices that have a model."""

SIMULATED_DRIVERS = (CameraDriver, ChipDriver, EventGamepadDriver)
"""The drivers of devices that are not on pins. The simulator's own devices replace these devices."""

MAX_ECHO_M = 4.3
"""The distance of the farthest wall whose echo an HC-SR04 receives, in metres."""


def connect_pins(binding: DeviceBinding, simulated: Robot, pins: VirtualPins, is_lost: Callable[[], bool]) -> bool:
    """Connect a device's pins by a model to the simulator's device; return whether there is a model of the device.

    is_lost: called for each ultrasonic echo; returns whether the echo is lost.
    """
    pin, clock = pins.pin, simulated.clock
    match binding.driver, binding.description, simulated.devices[binding.name]:
        case MotorDriver() as on, _, Motor() as motor:
            connect_motor(on, motor, pins)
        case ChannelDriver() as on, _, Motor() | Servo() as actuator:
            connect_channels(on, actuator, pins)
        case PinServoDriver() as on, _, Servo() as servo:
            wire_servo(servo, on, pin(on.gpio), lambda: FRAME_HZ)
        case Quadrature() | Pulses() as on, EncoderDescription() as description, Encoder() as encoder:
            numbers, levels = ((on.a, on.b), QUADRATURE) if isinstance(on, Quadrature) else ((on.gpio,), SLOTS)
            disc = Disc(encoder, math.tau / on.edges_per_turn(description), levels, [pin(each) for each in numbers])
            clock.call_every(_step_of(clock), disc.update, "disc")
        case Ultrasonic() as on, _, RangeSensor() as sensor:
            VirtualEcho(clock, sensor, pin(on.trigger), pin(on.echo), speed_of_sound(on.air_temperature_c), is_lost)
        case ContactDriver() as on, _, Bumper() | Button() as contact:
            line = pin(on.gpio)
            clock.call_every(_step_of(clock), lambda: line.drive(not contact.read().is_pressed), "switch")
        case PinLineSensorDriver() as on, _, LineSensor() as row:
            update = partial(drive_outputs, row, [pin(each) for each in on.gpios], on.active_high)
            update()
            clock.call_every(_step_of(clock), update, "line-sensors")
        case LightDriver() | PinBuzzerDriver() as on, _, Led() | Buzzer() as indicator:
            outputs = on.gpios if isinstance(on, LightDriver) else (on.gpio,)
            wire_indicator(indicator, [pin(each) for each in outputs], getattr(on, "active_high", True))
        case _:
            return False
    return True


def _step_of(clock: Clock) -> float:
    """Return the time in seconds between two updates of a model."""
    return clock.step if isinstance(clock, SteppedClock) else 1 / MIN_PHYSICS_RATE_HZ


def find_unmodelled(bindings: Iterable[DeviceBinding]) -> list[DeviceBinding]:
    """Return the devices without a model, which the simulator's own devices replace.

    The result has no devices that simulators lack, such as batteries.
    """
    return [
        binding
        for binding in bindings
        if not isinstance(binding.driver, MODELLED_DRIVERS) and load_kind(binding.description.kind).is_simulated
    ]


def describe_hardware(binding: DeviceBinding) -> DeviceDescription:
    """Return the description of a device's hardware, for the simulator.

    An encoder's counts are all of its edges. An ultrasonic module also measures walls beyond its ``max_range_m``, and
    its driver decides when it measures. A motor turns at full duty as fast as its model states.
    """
    match binding.driver, binding.description:
        case (MotorDriver() | ChannelMotorDriver()) as driver, MotorDescription() as description:
            return description.raise_max_velocity(max(driver.model.forward_rad_s, driver.model.backward_rad_s))
        case EncoderDriver() as driver, EncoderDescription() as description:
            return description.model_copy(update={"counts_per_turn": driver.edges_per_turn(description)})
        case Ultrasonic(), description:
            return description.model_copy(update={"max_range_m": MAX_ECHO_M, "latency_s": 0.0, "rate_hz": None})
    return binding.description
