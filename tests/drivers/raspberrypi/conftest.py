"""Fixtures for pins on the tests' simulated lines."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from drivers.raspberrypi.pins import open_pins
from tests.drivers.raspberrypi.lines import Lines, lgpio

PI_3 = 0xA02082


@pytest.fixture
def lines(tmp_path: Path) -> Lines:
    return Lines(tmp_path)


@pytest.fixture
def fake_lgpio(lines: Lines, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Lines:
    """Let gpiozero import the double of lgpio, as on a Pi 3; return its lines."""
    monkeypatch.setenv("FAKE_DEV", str(tmp_path))
    monkeypatch.setenv("GPIOZERO_PIN_FACTORY", "pigpio")  # has no effect
    monkeypatch.setitem(sys.modules, "lgpio", lgpio)
    monkeypatch.delitem(sys.modules, "gpiozero.pins.lgpio", raising=False)
    monkeypatch.setattr("gpiozero.pins.local.get_pi_revision", lambda: PI_3)
    return lines


@pytest.fixture
def pins(fake_lgpio: Lines) -> Iterator[Any]:
    """Return gpiozero's pins on the double of lgpio."""
    made = open_pins()
    yield made
    made.close()
