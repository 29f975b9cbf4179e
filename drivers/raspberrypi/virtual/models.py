"""Virtual pins in simulated time, and models of the hardware on these pins."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import partial
from typing import Any

from gpiozero.pins.mock import MockFactory, MockPWMPin

from robotcore.hal.clock import Clock
from robotcore.hal.devices import Encoder, Motor, RangeSensor

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

    def ticks(self) -> float:
        """Return the simulated time in seconds."""
        return self._clock.now()


QUADRATURE = ((1, 1), (0, 1), (0, 0), (1, 0))
"""The levels of the channels (a, b) after each edge of a forward turn, on which channel a leads."""


class Disc(ABC):
    """An encoder disc that turns with a wheel, and sets the encoder's pins.

    encoder: the simulator's encoder, which gives the angle of the wheel.
    radians: the angle between two edges.
    """

    def __init__(self, encoder: Encoder, radians: float) -> None:
        self._encoder, self._radians = encoder, radians
        self._at = 0

    def update(self) -> None:
        """Set the pins once for each edge that the wheel has passed since the last call."""
        target = round(self._encoder.read().angle / self._radians)
        step = 1 if target > self._at else -1
        while self._at != target:
            self._at += step
            self._show(self._at)

    @abstractmethod
    def _show(self, edge: int) -> None:
        """Set the pins to their levels after ``edge`` edges since the start. Backward edges count as negative."""


class QuadratureDisc(Disc):
    """An encoder disc with two channels, a quarter of a cycle apart, which show the direction."""

    def __init__(self, encoder: Encoder, radians: float, a: VirtualPin, b: VirtualPin) -> None:
        super().__init__(encoder, radians)
        self._a, self._b = a, b
        self._show(0)

    def _show(self, edge: int) -> None:
        a, b = QUADRATURE[edge % len(QUADRATURE)]
        self._a.drive(a)
        self._b.drive(b)


class SlottedDisc(Disc):
    """An encoder disc with one channel, which does not show the direction."""

    def __init__(self, encoder: Encoder, radians: float, pin: VirtualPin) -> None:
        super().__init__(encoder, radians)
        self._pin = pin
        self._show(0)

    def _show(self, edge: int) -> None:
        self._pin.drive(edge % 2)


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


Velocity = Callable[[float], float]
"""A function that returns a motor's velocity in rad/s for its duty from -1 to 1."""


def wire_two_inputs(
    motor: Motor, velocity: Velocity, forward: VirtualPin, backward: VirtualPin, enable: VirtualPin | None = None
) -> None:
    """Connect a motor to pins by an H-bridge with an input for each direction. Equal inputs brake the motor.

    velocity: the motor's velocity at each duty.
    enable: the pin that enables the H-bridge; None if it is always enabled.
    """

    def duty() -> float:
        return float(forward.state) - float(backward.state) if enable is None or enable.state else 0.0

    _turn_on_change(duty, motor, velocity, *(pin for pin in (forward, backward, enable) if pin is not None))


def wire_phase_and_enable(motor: Motor, velocity: Velocity, phase: VirtualPin, enable: VirtualPin) -> None:
    """Connect a motor to pins by an H-bridge with a direction input.

    velocity: the motor's velocity at each duty.
    phase: the pin that is high to turn backward.
    enable: the pin with the duty.
    """
    _turn_on_change(lambda: float(-enable.state if phase.state else enable.state), motor, velocity, phase, enable)


def _turn_on_change(duty: Callable[[], float], motor: Motor, velocity: Velocity, *pins: VirtualPin) -> None:
    for pin in pins:
        pin.on_change(lambda: motor.set_velocity(velocity(duty())))
