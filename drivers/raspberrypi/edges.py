"""Edges of a pin, which nobody is to hear any more."""

from __future__ import annotations

from threading import Event
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gpiozero import Pin

_TRIES = 100
_PAUSE_S = 0.01


def hear_no_more(pin: Pin) -> None:
    """Tell nobody of a pin's edges from now on.

    lgpio frees the line and claims it anew. Where its own thread is just waiting for edges, the kernel lets the line go
    only when that is back, and until then it is busy. Raises what the library raises where that goes on for a second.
    """
    for _ in range(_TRIES):
        if _has_let_go(pin):
            return
        Event().wait(_PAUSE_S)
    pin.when_changed = None


def _has_let_go(pin: Pin) -> bool:
    try:
        pin.when_changed = None
    except Exception as error:
        if "busy" not in str(error).lower():
            raise
        return False
    return True
