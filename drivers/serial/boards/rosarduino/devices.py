"""The counts and the motors of an Arduino, and the conversion of replies to samples."""

from __future__ import annotations

import math

from drivers.serial.boards.board import CountAccumulator, wrap_difference
from drivers.serial.boards.devices import BoardOutput
from drivers.serial.boards.rosarduino.protocol import MAX_COUNTS_PER_PERIOD
from robotcore.description import RobotDescription
from robotcore.errors import DeviceError
from robotcore.hardware import encoder_of
from robotcore.hardware.motor_model import OutputMotor
from robotcore.hardware.polled_samples import RangeSampler
from robotcore.kinds.encoder import EncoderDescription
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.range_sensor import RangeSensorDescription

MAX_COUNT_RATE_HZ = 50_000
"""The most encoder edges that an Arduino can count in a second."""

MISSED_S = 0.05
"""A pause between two counts that is longer than this many seconds: a reply was lost, or the board was reset."""

WRAPS_AT = 2**32
"""The number of counts after which the board's 32-bit counter wraps around."""

SAME_MEASUREMENT_S = 0.02
"""Two ranges belong to one measurement if their times differ by less than this many seconds. robotcore_bridge measures
every 0.06 s."""

MUTE_S = 0.5
"""An ultrasonic module that has not answered its trigger for this many seconds has failed."""

MUTE_PINGS = 3
"""After this many requests in a row without a pulse, an ultrasonic module of ROSArduinoBridge has failed. Each such
request takes a second."""

_MUTE = "the board's ultrasonic module does not answer its trigger; check its 5 V, its ground and its pins"


class WheelCounter(CountAccumulator):
    """Adds up the counts of a wheel's encoder, and ignores impossible counts.

    A count that is too far from the last one is ignored, unless the next count confirms it. A reset sets the board's
    counter to zero. So after a pause, a count that is nearer to zero than to the last count shows a reset. Turns
    during a reset are lost.
    """

    def __init__(self) -> None:
        super().__init__(WRAPS_AT)
        self._taken: tuple[int, float] | None = None
        self._doubted: tuple[int, float] | None = None

    def take(self, count: int, time: float) -> None:
        """Process a count that arrived at ``time``, in seconds. An impossible count is ignored."""
        if self._taken and _was_reset(count, time, *self._taken):
            self.restart()
        elif self._taken and not _follows(count, time, *self._taken):
            if not (self._doubted and _follows(count, time, *self._doubted)):
                self._doubted = count, time
                return
            self.restart()
        self._taken, self._doubted = (count, time), None
        self.add(count, time)

    def restart(self) -> None:
        super().restart()
        self._taken = self._doubted = None


def _was_reset(count: int, time: float, before: int, then: float) -> bool:
    return time - then > MISSED_S and abs(count) < abs(wrap_difference(count - before, WRAPS_AT))


def _follows(count: int, time: float, before: int, then: float) -> bool:
    return abs(wrap_difference(count - before, WRAPS_AT)) <= math.ceil((time - then) * MAX_COUNT_RATE_HZ)


class Ranges:
    """Converts the replies of robotcore_bridge to samples.

    A reply has the newest range in mm, or -1 without an echo, and the age of the range in ms.
    """

    def __init__(self, device: str, sampler: RangeSampler) -> None:
        self._device, self._sampler = device, sampler
        self._last: float | None = None

    def take(self, numbers: tuple[int, ...], now: float) -> None:
        """Convert the numbers in a reply that arrived at ``now``, in seconds, to a sample."""
        millimetres, age_ms = numbers
        time = now - age_ms / 1000
        if age_ms > MUTE_S * 1000:
            self._sampler.fail(DeviceError(self._device, _MUTE, kind="module-silent"))
        elif self._last is None or time - self._last > SAME_MEASUREMENT_S:
            self._last = time
            if millimetres < 0:
                self._sampler.clear_failure()
                self._sampler.add_no_echo(time)
            else:
                self._sampler.add_distance(millimetres / 1000, time)


class Pings:
    """Converts the replies of ROSArduinoBridge to samples. A reply has a range in cm, or 0 without a pulse.

    If no echo returns, the module ends its pulse after its own time-out, which gives a range beyond the maximum. So
    such a range means a far target or no echo.
    """

    def __init__(self, description: RangeSensorDescription, sampler: RangeSampler) -> None:
        self._description, self._sampler = description, sampler
        self._silent_pings = 0

    def take(self, numbers: tuple[int, ...], now: float) -> None:
        """Convert the number in a reply that arrived at ``now``, in seconds, to a sample."""
        distance = numbers[0] / 100
        self._silent_pings = 0 if distance else self._silent_pings + 1
        if self._silent_pings >= MUTE_PINGS:
            self._sampler.fail(DeviceError(self._description.name, _MUTE, kind="module-silent"))
        elif not distance:
            self._sampler.add_unclear()
        elif distance > self._description.max_range_m:
            self._sampler.clear_failure()
            self._sampler.add_no_echo(now)
        else:
            self._sampler.add_distance(distance, now)


class CountingMotor(OutputMotor):
    """A motor on a board that accepts only whole counts per control period.

    `set_velocity` rounds to the nearest velocity of whole counts. Less than half a count per control period becomes 0.
    ``max_velocity`` is a whole number of counts per control period too.

    counts_per_rad_s: the number of counts in a control period at 1 rad/s.
    """

    def __init__(self, description: MotorDescription, output: BoardOutput, counts_per_rad_s: float) -> None:
        super().__init__(description, output)
        self._counts_per_rad_s = counts_per_rad_s
        self.max_velocity = math.floor(description.max_velocity_rad_s * counts_per_rad_s) / counts_per_rad_s

    def set_velocity(self, rad_s: float) -> float:
        return self._round(super().set_velocity(rad_s))

    def _apply(self, rad_s: float) -> None:
        super()._apply(self._round(rad_s))

    def _round(self, rad_s: float) -> float:
        return round(rad_s * self._counts_per_rad_s) / self._counts_per_rad_s


def edges_per_turn(description: EncoderDescription, counts: object) -> int:
    """Return the edges in a turn of the wheel. The board counts all edges, four in each cycle.

    counts: the setting ``counts`` of the encoder, "cycles" or "edges".
    """
    return description.counts_per_turn * (1 if counts == "edges" else 4)


ENCODER = "ros-arduino-encoder"
"""The name of the driver of encoders on an Arduino."""

CONTROL_RATE_HZ = 30
"""The rate of the board's velocity control. It takes counts in a period of it."""


def counts_per_turn(motor: str, port: str, robot: RobotDescription) -> int:
    """Return the board's counts in a turn of a motor's wheel, from the settings of the wheel's encoder.

    port: the port of the motor's board.

    Raises ValueError if the robot's file has no encoder of this wheel on the motor's port.
    """
    name, elsewhere = encoder_of(motor, robot), ""
    for description in robot.all_of(EncoderDescription):
        for section in robot.backends.values():
            found = section.get(name) if description.name == name else None
            table = found if isinstance(found, dict) else {}  # the check of the encoder reports another type
            if table.get("driver") == ENCODER and table.get("port") == port:
                return edges_per_turn(description, table.get("counts"))
            elsewhere = table.get("port", elsewhere) if table.get("driver") == ENCODER else elsewhere
    if elsewhere:
        raise ValueError(
            f"the board of {motor} is on {port} and needs the encoder {name}, which is on {elsewhere}; write "
            "the same port for both"
        )
    raise ValueError(
        f"the board controls the velocity of {motor} by its wheel's encoder, but no encoder is on {port}; "
        f"name the encoders in [drive] and connect them with {ENCODER}, or add the motor's model"
    )


def require_countable(description: MotorDescription, counts: int) -> None:
    """Raise ValueError if the motor's maximum velocity is impossible on the board.

    The limits are one count and `MAX_COUNTS_PER_PERIOD` counts per control period.

    counts: the board's counts in a turn of the wheel.
    """
    fastest = description.max_velocity_rad_s * counts / math.tau / CONTROL_RATE_HZ
    if fastest < 1:
        raise ValueError(
            f"max_velocity_rad_s of {description.name} is {fastest:.2g} counts per control period of 1/30 s, but the "
            "board takes whole counts; use encoders with more counts, or add the motor's model"
        )
    if fastest > MAX_COUNTS_PER_PERIOD:
        raise ValueError(
            f"max_velocity_rad_s of {description.name} is {fastest:.0f} counts per control period of 1/30 s, but "
            f"the board takes {MAX_COUNTS_PER_PERIOD} at most; "
            f"lower it to {math.floor(description.max_velocity_rad_s * MAX_COUNTS_PER_PERIOD / fastest)}"
        )
