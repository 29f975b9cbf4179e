"""The driver of a servo on a GPIO, which is commanded by the width of pulses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.pins import open_output
from robotcore.description import RobotDescription
from robotcore.errors import Mistake
from robotcore.hal.device_test import AT_OTHER_ANGLES, REVERSED
from robotcore.hardware import Connection, DeviceContext, DeviceDriver, Drivers
from robotcore.kinds.servo import Servo, ServoDescription

SUPPLY = (
    "The servo needs a supply of its own, usually 5 to 6 V. A pad of the header gives too little current for a servo "
    "under load, and the Pi may restart. Join the grounds of the supply and the Pi."
)
"""The note that `robotcore wiring` prints for each servo."""

FRAME_HZ = 50
"""The number of pulses in a second. All servos for models take this rate."""


MIN_PULSE_S, MAX_PULSE_S = 0.0003, 0.003
"""The narrowest and the widest pulse of a servo, in seconds."""


def _require_seconds(width: Any) -> Any:
    if isinstance(width, (int, float)):
        for unit, factor in (("ms", 1e-3), ("µs", 1e-6)):
            if MIN_PULSE_S <= width * factor <= MAX_PULSE_S:
                remedy = f"Did you mean {width:g} {unit}? That is {width * factor:g} s"
                raise Mistake(f"{width:g} s is too long for a pulse", remedy, kind="out-of-bounds")
    return width


PulseWidth = Annotated[float, Field(ge=MIN_PULSE_S, le=MAX_PULSE_S), BeforeValidator(_require_seconds)]
"""The width of a servo's pulse, in seconds."""


class PinServo(Servo):
    """A servo on a GPIO. After closing it gets no pulses.

    line: gpiozero's output of the GPIO, with PWM of `FRAME_HZ`.
    number: the number of the GPIO.
    pulses: the widths of the pulses at the least and the greatest angle, in seconds.
    opened: the stack whose `close` frees the GPIO.
    """

    def __init__(
        self, description: ServoDescription, line: Any, number: int, pulses: tuple[float, float], opened: ExitStack
    ) -> None:
        super().__init__(description.name, **description.arguments())
        self._line, self._number, self._pulses, self._opened = line, number, pulses, opened

    def _apply(self, command: float) -> None:
        write_duty(self._line.pin, self._number, find_width(self, self._pulses, command) * FRAME_HZ)

    def _release(self) -> None:
        self._opened.close()


def find_width(servo: Servo, pulses: tuple[float, float], angle: float) -> float:
    """Return the width of the pulse at an angle, in seconds.

    pulses: the widths at the least and the greatest angle, in seconds.
    angle: the angle in radians.
    """
    least, greatest = pulses
    share = (angle - servo.min_angle) / (servo.max_angle - servo.min_angle)
    return least + share * (greatest - least)


def write_duty(pin: Any, number: int, duty: float) -> None:
    """Set the duty, 0 to 1, of a pin with PWM of `FRAME_HZ`.

    gpiozero gives lgpio only whole percent, which are steps of 0.2 ms: the servo would have six positions. lgpio itself
    takes fractions. So they go to lgpio without gpiozero.

    number: the number of the GPIO.
    """
    handle = getattr(pin.factory, "_handle", None)
    if hasattr(pin, "set_duty"):  # a virtual pin
        pin.set_duty(duty)
    elif handle is None:
        pin.state = duty
    else:
        import lgpio

        lgpio.tx_pwm(handle, number, FRAME_HZ, 100 * duty)


class PulseDriver(DeviceDriver):
    """The base class of the drivers of servos, with the settings of the pulses."""

    described = ServoDescription

    min_pulse_s: PulseWidth = 0.001
    """The width of the pulse at ``min_angle_rad``, in seconds. It may be the wider one, to reverse the direction."""
    max_pulse_s: PulseWidth = 0.002
    """The width of the pulse at ``max_angle_rad``, in seconds."""

    @property
    def pulses(self) -> tuple[float, float]:
        return self.min_pulse_s, self.max_pulse_s

    def notes(self, description: ServoDescription) -> Sequence[str]:
        return (SUPPLY,)

    def correct(self, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        if mistake == REVERSED:
            return {"min_pulse_s": self.max_pulse_s, "max_pulse_s": self.min_pulse_s}
        if mistake != AT_OTHER_ANGLES:
            return None
        span = self.max_pulse_s - self.min_pulse_s
        widths = [round(self.min_pulse_s + share * span, 6) for share in observed]
        if not all(MIN_PULSE_S <= width <= MAX_PULSE_S for width in widths):
            return None
        return dict(zip(("min_pulse_s", "max_pulse_s"), widths, strict=True))

    def check(self, description: ServoDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if self.min_pulse_s == self.max_pulse_s:
            raise ValueError(f"min_pulse_s and max_pulse_s are both {self.min_pulse_s:g}; correct one of them")


class PinServoDriver(PulseDriver):
    """Opens servos on a GPIO. An opened servo turns to its rest angle."""

    name = "servo"
    summary = "a servo on a GPIO, commanded by the width of pulses"
    modules = ("gpiozero",)
    connector = "GPIO"
    remedy = "pip install 'robotcore[pi]'"
    supply = ("ground",)

    gpio: Gpio

    def connections(self) -> Sequence[Connection]:
        return (gpio("gpio", self.gpio),)

    def open(self, description: ServoDescription, context: DeviceContext) -> Servo:
        with ExitStack() as undo:
            opened = undo.enter_context(ExitStack())
            line = open_output(description.name, self.gpio, context.pins, opened, frequency_hz=FRAME_HZ)
            servo = PinServo(description, line, self.gpio, self.pulses, opened)
            servo.set_angle(servo.angle)
            undo.pop_all()
        return servo
