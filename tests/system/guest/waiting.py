"""Waiting for what another process or thread brings about; generous, against a hang alone."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

from tests.system.speed import scaled

ValueT = TypeVar("ValueT")

PATIENCE_S = 6.0
"""On the reference machine; an emulated processor is some ten times slower."""


def settled(got: Callable[[], ValueT], expected: object) -> ValueT:
    """Return what was got last: what is expected as soon as it is, anything else when patience is at its end."""
    end = time.monotonic() + scaled(PATIENCE_S)
    while (value := got()) != expected and time.monotonic() < end:
        time.sleep(0.01)
    return value
