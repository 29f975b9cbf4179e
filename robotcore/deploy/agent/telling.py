"""What the robot says to the desk: JSON text sequences (RFC 7464), so that what a login shell prints is told apart."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from typing import Any

MARK = "\x1e"
"""Begins each line that is ours."""

Say = Callable[..., None]
"""Tells the desk of progress: words, and whatever an action has to say besides, by name."""


class RefusalError(Exception):
    """What was asked for cannot be done here: the fault, and what to do, in whole sentences.

    ``kind`` is a word for the desk, where it knows better what to do.
    """

    def __init__(self, fault: str, remedy: str, kind: str = "") -> None:
        super().__init__(f"{fault}. {remedy}")
        self.fault, self.remedy, self.kind = fault, remedy, kind


def say(words: str, **more: Any) -> None:
    """Tell of progress."""
    write({"say": words, **more})


def write(told: Any) -> None:
    """Write one line to the desk."""
    sys.stdout.write(f"{MARK}{json.dumps(told)}\n")
    sys.stdout.flush()
