"""The lines of JSON that a Waveshare UGV board takes and tells.

They are those of Waveshare's firmware ugv_base_ros (json_cmd.h, uart_ctrl.h, movtion_module.h, ugv_advance.h) in the
version of September 2024: 115200 baud 8N1, an object a line, LF taken, CR LF told.
"""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from drivers.serial.driver import Side

BAUD = 115200

FASTEST_M_S = 2.0
"""A board told to be faster on either side ignores the line, and goes on as it was told before."""

FEEDBACK_S = 0.05
"""How often the board tells where it is: a line of some 200 bytes is 17 ms on the way, in which its loop waits."""

BEGINNING = b'{"T":1001,'
"""Of a line that is feedback."""

LONGEST = 512
"""No line that the board tells has so many bytes: 330 with an arm."""

_Speed = Annotated[float, Field(ge=-10, le=10, allow_inf_nan=False)]
_Centimetres = Annotated[int, Field(ge=-(10**8), le=10**8)]


class Track(NamedTuple):
    """How far a side has come in cm, cut towards zero, and its speed in m/s; positive is forward."""

    centimetres: int
    speed: float


class Feedback(BaseModel):
    """What the board tells of itself, a line of type 1001.

    ``left_m_s`` and ``right_m_s`` are the tracks' speeds in the last round of the board's loop. ``left_cm`` and
    ``right_cm`` are how far they have come since the board was switched on, cut to whole centimetres towards zero.
    ``centivolts`` is the battery, in hundredths of a volt, measured every 10 s.

    >>> Feedback.model_validate_json('{"T":1001,"L":0.2,"R":0,"gx":5,"odl":12,"odr":-3,"v":1187}').right_cm
    -3
    """

    model_config = ConfigDict(frozen=True, strict=True)

    kind: Literal[1001] = Field(alias="T")
    left_m_s: _Speed = Field(alias="L")
    right_m_s: _Speed = Field(alias="R")
    left_cm: _Centimetres = Field(alias="odl")
    right_cm: _Centimetres = Field(alias="odr")
    centivolts: int = Field(alias="v", ge=-100, le=6000)

    def track(self, side: Side) -> Track:
        """Return what is told of one side."""
        return Track(self.left_cm, self.left_m_s) if side == "left" else Track(self.right_cm, self.right_m_s)


class Parser:
    """Finds feedback in what comes in, however it is cut; ``dropped`` counts the lines that are none.

    Such as echoes, what a board prints as it starts, and what noise has made of a line.
    """

    def __init__(self) -> None:
        self.dropped = 0
        self.is_older = False
        """Whether a board has told of itself as the older firmware, ugv_base_general, does: without odometers."""
        self._rest = b""

    def feed(self, data: bytes) -> list[Feedback]:
        """Take bytes; return what they complete."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        self._rest = self._rest[:LONGEST]  # of a line that is too long the end is not needed: it is dropped
        return [found for line in lines if (found := self._feedback(line))]

    def restart(self) -> None:
        """Forget the beginning of a line whose end does not come any more."""
        self._rest = b""

    def _feedback(self, line: bytes) -> Feedback | None:
        if line.startswith(BEGINNING) and len(line) < LONGEST:
            try:
                return Feedback.model_validate_json(line)
            except ValidationError:
                self.is_older = self.is_older or (b'"odl"' not in line and line.endswith(b"}\r"))
        self.dropped += 1
        return None


def greeting(timeout_s: float) -> bytes:
    """Return what makes any board one that is driven safely, and heard.

    It stops it, sets its own time-out, and has it take speeds as they are told, echo nothing, and give feedback by
    itself every `FEEDBACK_S`.
    """
    every = round(1000 * FEEDBACK_S)
    return (
        STOP
        + heartbeat(timeout_s)
        + b'{"T":138,"L":1,"R":1}\n{"T":143,"cmd":0}\n{"T":142,"cmd":%d}\n{"T":131,"cmd":1}\n' % every
    )


def heartbeat(timeout_s: float) -> bytes:
    """Return the line that has the motors stop where no `speeds` have come for so long."""
    return b'{"T":136,"cmd":%d}\n' % round(1000 * timeout_s)


def speeds(left_m_s: float, right_m_s: float) -> bytes:
    r"""Return the line that turns the tracks; the board holds these speeds by its own encoders.

    >>> speeds(0.25, -0.1)
    b'{"T":1,"L":0.2500,"R":-0.1000}\n'
    """
    return b'{"T":1,"L":%.4f,"R":%.4f}\n' % (left_m_s, right_m_s)


STOP = b"\n" + speeds(0.0, 0.0)
"""It stops both tracks, in the middle of somebody else's line too: the board takes no line that two have written.

Type 0, the board's emergency stop, would stop an arm on it too, and the older firmware does not know it.
"""

STANDING = r'\{"T":1001,"L":-?0(\.0\d*)?,"R":-?0(\.0\d*)?,'
"""Feedback of a board that has heard it: neither track goes at 0.1 m/s any more."""
