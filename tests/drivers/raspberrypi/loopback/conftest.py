"""Lines that wires connect, and gpiozero's pins on them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from drivers.raspberrypi.loopback.wires import LoopbackWire
from drivers.raspberrypi.pins import open_pins
from tests.drivers.raspberrypi.lines import Lines

WIRES = (LoopbackWire(1, 20, 21), LoopbackWire(2, 19, 26))
CONNECTED = "20:21,19:26"


@pytest.fixture
def wired_pins(fake_lgpio: Lines, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """Return pins that the two wires connect."""
    monkeypatch.setenv("FAKE_WIRES", CONNECTED)
    made = open_pins()
    yield made
    made.close()
