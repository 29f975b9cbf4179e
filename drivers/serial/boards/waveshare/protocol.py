"""The JSON lines and the protocol of a Waveshare UGV board, and an odometer finer than the board's centimetres.

Each line is one JSON object, at 115200 baud 8N1. A line to the board ends in LF, and a line from the board in CR LF.

Source: Waveshare's firmware ugv_base_ros of September 2024 (json_cmd.h, uart_ctrl.h, movtion_module.h, ugv_advance.h).
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from drivers.serial.boards.board import BoardProtocol, CountAccumulator
from drivers.serial.driver import Side

BAUD = 115200

MAX_SPEED_M_S = 2.0
"""The highest speed of a command in m/s. The board ignores a line with a higher speed, and continues with the previous
command."""

FEEDBACK_S = 0.05
"""The period of feedback in seconds. A shorter one would slow down the board's loop, which waits 17 ms for each
line."""

BEGINNING = b'{"T":1001,'
"""The first bytes of a line with feedback."""

MAX_LINE_LENGTH = 512
"""The parser drops lines of this many bytes or more. The longest line of a board, one with an arm, has 330 bytes."""

_Speed = Annotated[float, Field(ge=-10, le=10, allow_inf_nan=False)]
_Centimetres = Annotated[int, Field(ge=-(10**8), le=10**8)]


class TrackFeedback(NamedTuple):
    """The distance and the speed of the track on one side; positive is forward."""

    centimetres: int
    """The distance since power-on in centimetres, rounded towards zero."""
    speed: float
    """The speed in m/s."""


class Feedback(BaseModel):
    """The board's feedback, a line of type 1001.

    >>> Feedback.model_validate_json('{"T":1001,"L":0.2,"R":0,"gx":5,"odl":12,"odr":-3,"v":1187}').right_cm
    -3
    """

    model_config = ConfigDict(frozen=True, strict=True)

    kind: Literal[1001] = Field(alias="T")
    left_m_s: _Speed = Field(alias="L")
    """The speed of the left track in m/s, measured in the last cycle of the board's loop."""
    right_m_s: _Speed = Field(alias="R")
    left_cm: _Centimetres = Field(alias="odl")
    """The distance of the left track since power-on, in whole centimetres, rounded towards zero."""
    right_cm: _Centimetres = Field(alias="odr")
    centivolts: int = Field(alias="v", ge=-100, le=6000)
    """The voltage of the battery in hundredths of a volt, measured every 10 s."""

    def track(self, side: Side) -> TrackFeedback:
        """Return the distance and the speed of the track on one side."""
        return (
            TrackFeedback(self.left_cm, self.left_m_s)
            if side == "left"
            else TrackFeedback(self.right_cm, self.right_m_s)
        )


class Parser:
    """Finds feedback in a stream of bytes, which arrives in pieces of any length."""

    def __init__(self) -> None:
        self.is_older = False
        """Whether a line was feedback of the older firmware ugv_base_general, which has no odometers."""
        self._rest = b""

    def feed(self, data: bytes) -> list[Feedback]:
        """Parse received bytes; return the feedback in the lines that these bytes complete."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        self._rest = self._rest[:MAX_LINE_LENGTH]  # a longer line is dropped anyway
        return [found for line in lines if (found := self._feedback(line))]

    def restart(self) -> None:
        """Drop the stored part of an incomplete line."""
        self._rest = b""

    def _feedback(self, line: bytes) -> Feedback | None:
        if line.startswith(BEGINNING) and len(line) < MAX_LINE_LENGTH:
            try:
                return Feedback.model_validate_json(line)
            except ValidationError:
                self.is_older = self.is_older or (b'"odl"' not in line and line.endswith(b"}\r"))
        return None


def build_greeting(timeout_s: float) -> bytes:
    """Return the lines that prepare a board: stop its motors, set its time-out and request feedback.

    The period of the feedback is `FEEDBACK_S`. The lines also switch off the scaling of speeds and the echo.
    """
    period_ms = round(1000 * FEEDBACK_S)
    return (
        STOP
        + build_heartbeat(timeout_s)
        + b'{"T":138,"L":1,"R":1}\n{"T":143,"cmd":0}\n{"T":142,"cmd":%d}\n{"T":131,"cmd":1}\n' % period_ms
    )


def build_heartbeat(timeout_s: float) -> bytes:
    """Return the line that sets the board's time-out in seconds.

    The board stops its motors if it receives no line of `build_speed_command` for this time.
    """
    return b'{"T":136,"cmd":%d}\n' % round(1000 * timeout_s)


def build_speed_command(left_m_s: float, right_m_s: float) -> bytes:
    r"""Return the line that sets the speeds of both tracks, which the board controls with its own encoders.

    >>> build_speed_command(0.25, -0.1)
    b'{"T":1,"L":0.2500,"R":-0.1000}\n'
    """
    return b'{"T":1,"L":%.4f,"R":%.4f}\n' % (left_m_s, right_m_s)


STOP = b"\n" + build_speed_command(0.0, 0.0)
"""The line that stops both tracks. It begins with LF, because another program may have written half a line.

It is not the board's emergency stop (type 0), which also stops an arm, and which the older firmware does not have.
"""

STANDING = r'\{"T":1001,"L":-?0(\.0\d*)?,"R":-?0(\.0\d*)?,'
"""A regular expression for feedback with both tracks slower than 0.1 m/s, which confirms `STOP`."""


JITTER_S = 0.1
"""The largest difference between the delays of two lines from the board, in seconds."""

IMPOSSIBLE_M_S = 3.0
"""A speed that no track reaches, not even downhill, in m/s. Feedback of a faster track is noise."""


class Odometer(CountAccumulator):
    """The distance of a track in metres, from the board's odometer in whole centimetres and from the measured speed.

    The estimate is always within the centimetre that the board sends. So its error is below 1 cm, and does not grow.

    >>> odometer = Odometer()
    >>> for time, centimetres in ((0.0, 0), (0.05, 0), (0.1, 2)):
    ...     odometer.move(TrackFeedback(centimetres, 0.1), time)
    ...     print(f"{odometer.angle(1.0).angle:g} m")
    0 m
    0.005 m
    0.02 m
    """

    _position: tuple[float, float, float] | None = None
    """The position in metres, the speed in m/s and the time of the newest feedback."""

    def restart(self) -> None:
        super().restart()
        self._position = None

    def is_plausible(self, track: TrackFeedback, time: float) -> bool:
        """Return whether the track can have moved to this distance since the last feedback.

        track: the distance and the speed in new feedback. A wrong digit makes the distance impossible.
        time: the time of arrival of the feedback, in seconds.
        """
        if self._position is None:
            return True
        metres, _, last_time = self._position
        low, high = _centimetre_bounds(track.centimetres)
        farthest = IMPOSSIBLE_M_S * (time - last_time + JITTER_S)
        return low - farthest <= metres <= high + farthest

    def move(self, track: TrackFeedback, time: float) -> None:
        """Add the distance of new feedback, which arrived at ``time`` in seconds."""
        low, high = _centimetre_bounds(track.centimetres)
        guess = (low + high) / 2
        if self._position:
            metres, speed, last_time = self._position
            guess = metres + (speed + track.speed) / 2 * (time - last_time)
        self._position = min(max(guess, low), high), track.speed, time
        self.add(self._position[0], time)


def _centimetre_bounds(centimetres: int) -> tuple[float, float]:
    # The board rounds towards zero.
    low = centimetres if centimetres > 0 else centimetres - 1
    high = centimetres if centimetres < 0 else centimetres + 1
    return low / 100, high / 100


SILENCE_S = 0.3
"""A board that has sent nothing for this many seconds is unplugged or was reset. A board cannot receive during its
reset."""

GREETING_S = 0.5
"""The period of sending the greeting until the board sends feedback, in seconds."""


class WaveshareProtocol(BoardProtocol):
    """Sends a greeting until the board sends feedback, and then each new command once. Commands are in m/s.

    Before each command it sends the line that sets the board's time-out, because it may not detect a short reset of the
    board. If the board falls silent, the protocol drops the command and sends the greeting again.
    """

    silence_s = SILENCE_S
    default_timeout_s = 0.5
    """The time-out in seconds if no motor is open. It stops motors that another program turns."""

    def __init__(self, baud: int) -> None:
        super().__init__(baud)
        self.counters: dict[Side, Odometer] = {"left": Odometer(), "right": Odometer()}
        self.parser = Parser()
        self._is_greeted = False
        self._greet_at = -math.inf

    def begin(self, now: float) -> None:
        self.parser.restart()
        super().begin(now)

    def receive(self, data: bytes, now: float) -> None:
        for feedback in self.parser.feed(data):
            if self._is_greeted:
                self._take_feedback(feedback, now)

    def data_to_send(self, now: float) -> bytes:
        self._lose_if_silent(now)
        if self.is_ready:
            wheels = self.command.take(now, self.timeout_s) or self.command.repeat_stop(now)
            return build_heartbeat(self.timeout_s) + build_speed_command(*wheels) if wheels else b""
        if now < self._greet_at:
            return b""
        self._greet_at, self._is_greeted = now + GREETING_S, True
        return build_greeting(self.timeout_s)

    def next_due(self, now: float) -> float:
        if not self.is_ready:
            return self._greet_at
        return min(self.command.next_due, self.command.repeat_due, self._received_at + SILENCE_S)

    def explain_silence(self, place: str, *, has_received: bool = False) -> str:
        if not self.parser.is_older:
            return super().explain_silence(place, has_received=has_received)
        return (
            f"the board on {place} runs ugv_base_general, which has no odometer and does not control the speed of most "
            "rovers. Flash Waveshare's ugv_base_ros"
        )

    def _lose(self, now: float) -> None:
        super()._lose(now)
        self._is_greeted, self._greet_at = False, now

    def _take_feedback(self, feedback: Feedback, now: float) -> None:
        tracks = [(odometer, feedback.track(side)) for side, odometer in self.counters.items()]
        if not self.is_ready:
            for odometer, _ in tracks:
                odometer.restart()
        elif not all(odometer.is_plausible(track, now) for odometer, track in tracks):
            return
        for odometer, track in tracks:
            odometer.move(track, now)
        self._set_voltage(feedback.centivolts / 100, now)
        self._received_at = now
        if not self.is_ready:
            self._set_ready()
