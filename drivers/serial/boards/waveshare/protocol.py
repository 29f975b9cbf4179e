"""The JSON lines that a Waveshare UGV board receives and sends.

Each line is one JSON object, at 115200 baud 8N1. A line to the board ends in LF, and a line from the board in CR LF.

Source: Waveshare's firmware ugv_base_ros of September 2024 (json_cmd.h, uart_ctrl.h, movtion_module.h, ugv_advance.h).
"""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from drivers.serial.driver import Side

BAUD = 115200

FASTEST_M_S = 2.0
"""The highest speed of a command in m/s. The board ignores a line with a higher speed, and continues with the previous
command."""

FEEDBACK_S = 0.05
"""The period of feedback in seconds. A shorter one would slow down the board's loop, which waits 17 ms for each
line."""

BEGINNING = b'{"T":1001,'
"""The first bytes of a line with feedback."""

LONGEST = 512
"""The parser drops lines of this many bytes or more. The longest line of a board, one with an arm, has 330 bytes."""

_Speed = Annotated[float, Field(ge=-10, le=10, allow_inf_nan=False)]
_Centimetres = Annotated[int, Field(ge=-(10**8), le=10**8)]


class Track(NamedTuple):
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

    def track(self, side: Side) -> Track:
        """Return the distance and the speed of the track on one side."""
        return Track(self.left_cm, self.left_m_s) if side == "left" else Track(self.right_cm, self.right_m_s)


class Parser:
    """Finds feedback in a stream of bytes, which arrives in pieces of any length."""

    def __init__(self) -> None:
        self.is_older = False
        """Whether a line was feedback of the older firmware ugv_base_general, which has no odometers."""
        self._rest = b""

    def feed(self, data: bytes) -> list[Feedback]:
        """Parse received bytes; return the feedback in the lines that these bytes complete."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        self._rest = self._rest[:LONGEST]  # a longer line is dropped anyway
        return [found for line in lines if (found := self._feedback(line))]

    def restart(self) -> None:
        """Drop the stored part of an incomplete line."""
        self._rest = b""

    def _feedback(self, line: bytes) -> Feedback | None:
        if line.startswith(BEGINNING) and len(line) < LONGEST:
            try:
                return Feedback.model_validate_json(line)
            except ValidationError:
                self.is_older = self.is_older or (b'"odl"' not in line and line.endswith(b"}\r"))
        return None


def greeting(timeout_s: float) -> bytes:
    """Return the lines that prepare a board: stop its motors, set its time-out and request feedback.

    The period of the feedback is `FEEDBACK_S`. The lines also switch off the scaling of speeds and the echo.
    """
    period_ms = round(1000 * FEEDBACK_S)
    return (
        STOP
        + heartbeat(timeout_s)
        + b'{"T":138,"L":1,"R":1}\n{"T":143,"cmd":0}\n{"T":142,"cmd":%d}\n{"T":131,"cmd":1}\n' % period_ms
    )


def heartbeat(timeout_s: float) -> bytes:
    """Return the line that sets the board's time-out in seconds.

    The board stops its motors if it receives no line of `speeds` for this time.
    """
    return b'{"T":136,"cmd":%d}\n' % round(1000 * timeout_s)


def speeds(left_m_s: float, right_m_s: float) -> bytes:
    r"""Return the line that sets the speeds of both tracks, which the board controls with its own encoders.

    >>> speeds(0.25, -0.1)
    b'{"T":1,"L":0.2500,"R":-0.1000}\n'
    """
    return b'{"T":1,"L":%.4f,"R":%.4f}\n' % (left_m_s, right_m_s)


STOP = b"\n" + speeds(0.0, 0.0)
"""The line that stops both tracks. It begins with LF, because another program may have written half a line.

It is not the board's emergency stop (type 0), which also stops an arm, and which the older firmware does not have.
"""

STANDING = r'\{"T":1001,"L":-?0(\.0\d*)?,"R":-?0(\.0\d*)?,'
"""A regular expression for feedback with both tracks slower than 0.1 m/s, which confirms `STOP`."""
