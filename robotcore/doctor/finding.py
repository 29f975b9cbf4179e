"""One thing that was looked at."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Level(str, Enum):
    """How bad it is: with an error a run fails or is unsafe, with a warning it may be worse than it could be."""

    OK = "ok"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True)
class Finding:
    """What was looked at, in a word or two, what was found, and what to do where it is not ok.

    >>> Finding.warning("disk", "0.4 GB are free", "Delete old recordings").level.value
    'warning'
    """

    level: Level
    what: str
    said: str
    remedy: str = ""

    @classmethod
    def ok(cls, what: str, said: str) -> Finding:
        """Return that it is as it should be."""
        return cls(Level.OK, what, said)

    @classmethod
    def warning(cls, what: str, said: str, remedy: str) -> Finding:
        """Return what may do harm."""
        return cls(Level.WARNING, what, said, remedy)

    @classmethod
    def error(cls, what: str, said: str, remedy: str) -> Finding:
        """Return what keeps a robot from running, or from running safely."""
        return cls(Level.ERROR, what, said, remedy)

    @classmethod
    def unchecked(cls, what: str, why: str, remedy: str = "") -> Finding:
        """Return that nobody knows: never taken for ok."""
        return cls(Level.WARNING, what, f"could not be checked: {why}", remedy)
