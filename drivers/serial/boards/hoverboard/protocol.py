"""The frames and the protocol of the Hoverboard FOC firmware.

The computer sends commands of 8 bytes, the board feedback of 18 bytes. All numbers are little-endian.

Source: EFeru/hoverboard-firmware-hack-FOC, `SerialCommand` in Inc/util.h, `SerialFeedback` in Src/main.c,
`usart_process_command` in Src/util.c.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import product
from operator import xor
from typing import NamedTuple

from drivers.serial.boards.board import BoardProtocol, CountAccumulator
from drivers.serial.driver import Side

START = 0xABCD
"""The first word of each frame in both directions (SERIAL_START_FRAME)."""

LIMIT = 1000
"""The limit of steer, speed and wheel values, which are from -1000 to 1000 (INPUT_MIN, INPUT_MAX)."""

_COMMAND = struct.Struct("<HhhH")
_FEEDBACK = struct.Struct("<H6hHH")
_WORDS = struct.Struct("<9H")
_START_BYTES = START.to_bytes(2, "little")

_MAX_INPUT = 1500
"""The limit of the steer and the speed in feedback. With field weakening (FIELD_WEAK_HI), they exceed `LIMIT`."""

_MAX_RPM = 2048
"""The limit of a measured speed in rpm. The firmware stores a speed in sixteenths of an rpm, as a signed 16-bit
number."""

_MAX_CENTIVOLTS = 10_000
"""The limit of a voltage in hundredths of a volt. No hoverboard withstands 100 V."""

_MAX_LED = 0xFF
"""The limit of the LED state in feedback, which is a byte."""


def build_command(steer: int, speed: int) -> bytes:
    """Return the frame of a command. The board's mixer computes the wheel values from steer and speed.

    >>> build_command(0, 0).hex(" ")
    'cd ab 00 00 00 00 cd ab'
    """
    checksum = START ^ steer & 0xFFFF ^ speed & 0xFFFF
    return _COMMAND.pack(START, steer, speed, checksum)


STOP = build_command(0, 0)
"""The frame that stops both wheels."""

STANDING = r"\xcd\xab\0\0\0\0"
"""A regular expression for the first bytes of feedback with steer and speed 0, which confirms `STOP`."""


@dataclass(frozen=True, slots=True)
class Feedback:
    """The content of a feedback frame, which the board sends a hundred times a second."""

    steer: int
    """The steer of the newest command that the board received; 0 after the board's time-out."""
    speed: int
    """The speed of the newest command that the board received; 0 after the board's time-out."""
    right_rpm: int
    """The measured speed of the right motor in rpm. The motor is mounted the other way round, so the speed is negative
    if the robot drives forward."""
    left_rpm: int
    """The measured speed of the left motor in rpm, positive if the robot drives forward."""
    battery_v: float

    @property
    def is_stopped(self) -> bool:
        """Whether the board's present command is a stop, received or set by the board's time-out."""
        return self.steer == self.speed == 0

    def centre_rpm(self, side: Side) -> float:
        """Return a motor's measured speed in rpm, without the bias of the board, which rounds down to whole rpm.

        If the robot drives forward, the motors have speeds of opposite signs. So rounding makes one amount smaller and
        the other one larger, and a straight drive would look like a turn.
        """
        measured = self.left_rpm if side == "left" else self.right_rpm
        return measured + 0.5 if measured else 0.0


class Parser:
    """Finds feedback in a stream of bytes, which arrives in pieces of any length and may have noise.

    After a broken frame the search continues at the frame's second byte, so that no valid frame is lost. The parser
    stores less than one frame.

    >>> parser = Parser()
    >>> frame = bytes.fromhex("cd ab 00 00 00 00 d8 ff 28 00 d4 0e 2c 01 00 00 c5 5b")
    >>> parser.feed(b"noise" + frame[:9]), parser.feed(frame[9:])
    ([], [Feedback(steer=0, speed=0, right_rpm=-40, left_rpm=40, battery_v=37.96)])
    """

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> list[Feedback]:
        """Parse received bytes; return the frames that these bytes complete."""
        stream, found, at = self._rest + data, [], 0
        while (at := _find_start(stream, at)) + _FEEDBACK.size <= len(stream):
            feedback = _parse_feedback(stream, at)
            found += [feedback] if feedback else []
            at += _FEEDBACK.size if feedback else 1
        self._rest = stream[at:]
        return found


def _find_start(stream: bytes, at: int) -> int:
    # The last byte of the stream may be the first half of a start.
    if (start := stream.find(_START_BYTES, at)) >= 0:
        return start
    return len(stream) - stream.endswith(_START_BYTES[:1], at)


def _parse_feedback(stream: bytes, at: int) -> Feedback | None:
    if reduce(xor, _WORDS.unpack_from(stream, at)):
        return None
    _, steer, speed, right_rpm, left_rpm, centivolts, _, led, _ = _FEEDBACK.unpack_from(stream, at)
    is_sound = (
        max(abs(steer), abs(speed)) <= _MAX_INPUT
        and max(abs(right_rpm), abs(left_rpm)) <= _MAX_RPM
        and 0 <= centivolts <= _MAX_CENTIVOLTS
        and led <= _MAX_LED
    )
    return Feedback(steer, speed, right_rpm, left_rpm, centivolts / 100) if is_sound else None


ONE = 1 << 14
"""The fixed-point value of 1.0 for the firmware's coefficients."""


class SteerCommand(NamedTuple):
    """The steer and the speed of a command, each from -1000 to 1000."""

    steer: int
    speed: int


@dataclass(frozen=True)
class Mixer:
    """The board's mixer, which converts steer and speed to wheel values from -1000 to 1000. Positive is forward.

    Steer and speed are multiplied by their coefficients. The left wheel's value is speed plus steer, and the right
    wheel's value is speed minus steer. With TANK_STEERING, steer is the left wheel's value, and speed the right one's.

    Source: `mixerFcn` in the firmware's Src/util.c.

    >>> Mixer().steering(101, 100), Mixer().wheels(SteerCommand(1, 101))
    (SteerCommand(steer=1, speed=101), (101, 100))
    >>> Mixer().steering(-1000, 1000)
    SteerCommand(steer=-1000, speed=0)
    >>> Mixer(is_tank=True).steering(-2000, 1000)
    SteerCommand(steer=-1000, speed=500)
    """

    speed_coefficient: float = 1.0
    """SPEED_COEFFICIENT in the firmware's config.h, divided by 16384."""
    steer_coefficient: float = 0.5
    """STEER_COEFFICIENT in the firmware's config.h, divided by 16384."""
    is_tank: bool = False
    """Whether TANK_STEERING is defined in the firmware's config.h. Then the coefficients have no effect."""

    def __str__(self) -> str:
        if self.is_tank:
            return "tank steering"
        return f"coefficients {self.speed_coefficient:g} and {self.steer_coefficient:g}"

    @property
    def straight(self) -> float:
        """The largest value that both wheels can have at the same time on a straight path."""
        return LIMIT if self.is_tank else LIMIT * min(self.speed_coefficient, 1.0)

    @property
    def turning(self) -> float:
        """The largest value on a turn on the spot, in which the wheels have opposite values."""
        return LIMIT if self.is_tank else LIMIT * min(abs(self.steer_coefficient), 1.0)

    def steering(self, left: float, right: float) -> SteerCommand:
        """Return the steer and the speed for the wheel values ``left`` and ``right``.

        If a value is too large, both are scaled down, so that the robot drives the same curve.
        """
        scale = _scale_to_limit(left, right)
        if self.is_tank:
            return SteerCommand(round(left * scale), round(right * scale))
        steer = (left - right) * scale / 2 / self.steer_coefficient
        speed = (left + right) * scale / 2 / self.speed_coefficient
        scale *= (again := _scale_to_limit(steer, speed))
        near = product(_nearby_integers(steer * again), _nearby_integers(speed * again))
        wanted = left * scale, right * scale
        return min((SteerCommand(*words) for words in near), key=lambda words: math.dist(self.wheels(words), wanted))

    def wheels(self, steering: SteerCommand) -> tuple[int, int]:
        """Return the left and the right wheel value for a steer and a speed, exactly as the firmware computes them."""
        if self.is_tank:
            return steering
        steer = steering.steer * 16 * round(self.steer_coefficient * ONE) >> 14
        speed = steering.speed * 16 * round(self.speed_coefficient * ONE) >> 14
        return _clamp(speed + steer >> 4), _clamp(speed - steer >> 4)


def _scale_to_limit(*words: float) -> float:
    return min(1.0, LIMIT / max(map(abs, (*words, 1.0))))


def _nearby_integers(word: float) -> range:
    below = math.floor(word)
    return range(max(below, -LIMIT), min(below + 2, LIMIT) + 1)


def _clamp(wheel: int) -> int:
    return max(-LIMIT, min(wheel, LIMIT))


PAUSE_S = 0.005
"""The pause between two commands, in seconds. The board detects the end of a command by a pause. It ignores two
commands without a pause in between."""

SILENCE_S = 0.4
"""A board that has sent nothing for this many seconds is lost. A board beeps for 0.3 s when its motors start, and sends
nothing during that time."""


class HoverboardProtocol(BoardProtocol):
    """Sends the wheels' commands, converted for the board's mixer, and integrates the speeds in the feedback.

    A stop is repeated, because a board that receives nothing for 0.8 s beeps and reports an error. While the board is
    silent, the angles do not change, because there is no speed to integrate.
    """

    silence_s = SILENCE_S
    default_timeout_s = 0.8
    """SERIAL_TIMEOUT in the firmware's config.h, in seconds. No command can change it."""

    def __init__(self, baud: int) -> None:
        super().__init__(baud)
        self.mixer = Mixer()
        self.counters = {"left": CountAccumulator(), "right": CountAccumulator()}
        """The turns of each motor, in sixtieths of a turn (rpm times seconds). The right motor is mounted the other way
        round, so it counts down if the robot drives forward."""
        self._turned: dict[Side, float] = {"left": 0.0, "right": 0.0}
        self._parser = Parser()
        self._last: Feedback | None = None
        self._sent_at = self._free_at = -math.inf

    def begin(self, now: float) -> None:
        super().begin(now)
        self._parser, self._last = Parser(), None

    def receive(self, data: bytes, now: float) -> None:
        if received := self._parser.feed(data):
            self._integrate(received, now)
            self._last, self._received_at = received[-1], now
            if not self.is_ready:
                self._set_ready()

    def data_to_send(self, now: float) -> bytes:
        self._lose_if_silent(now)
        if not self.is_ready:
            self.command.clear()  # a silent board may still receive, and gets a stop
        if now < self._free_at:
            return b""
        if not (wheels := self.command.take(now, self.timeout_s) or self.command.repeat_stop(now)):
            return b""
        self._sent_at, self._free_at = now, now + PAUSE_S
        return build_command(*self.mixer.steering(*wheels))

    def next_due(self, now: float) -> float:
        return max(self._free_at, min(self.command.next_due, self.command.repeat_due))

    @property
    def is_settled(self) -> bool:
        """Whether the last command was sent. For a stop: whether the board's feedback confirms it too."""
        is_confirmed = self._last is not None and self._last.is_stopped and self._received_at > self._sent_at
        return super().is_settled and (is_confirmed or not self.command.newest.is_stop)

    def _integrate(self, received: Sequence[Feedback], now: float) -> None:
        each_s = (now - self._received_at) / len(received)
        before = self._last
        for feedback in received:
            if before and each_s <= SILENCE_S:
                for side in self._turned:
                    self._turned[side] += (before.centre_rpm(side) + feedback.centre_rpm(side)) / 2 * each_s
            before = feedback
        for side, counter in self.counters.items():
            counter.add(self._turned[side], now)
        self._set_voltage(received[-1].battery_v, now)
