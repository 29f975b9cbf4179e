"""Who asked: the line of an app's own code that led to a call of the framework."""

from __future__ import annotations

import sys
from pathlib import Path
from types import FrameType

_OURS = "robotcore"
_LOOP = "robotcore.running.loop"
"""It calls apps: what is outside of it is none."""


def asking_line() -> str:
    """Return ``file.py:line`` of the innermost code on this thread's stack that is not the framework's.

    Empty where the framework asked of itself.
    """
    frame: FrameType | None = sys._getframe(1)  # noqa: SLF001  the one way to see who calls
    while frame and _module(frame).partition(".")[0] == _OURS:
        frame = None if _module(frame) == _LOOP else frame.f_back
    return f"{Path(frame.f_code.co_filename).name}:{frame.f_lineno}" if frame else ""


def _module(frame: FrameType) -> str:
    return str(frame.f_globals.get("__name__"))
