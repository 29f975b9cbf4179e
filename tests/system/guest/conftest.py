"""Fixtures of the checks in the guest: a new chip for each check, and gpiozero's pins on it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tests.system.guest.chip import Chip


@pytest.fixture(scope="session", autouse=True)
def _lgpio_is_running() -> None:
    """Import lgpio before any check, because its thread lives as long as the process."""
    from drivers.raspberrypi.chip import load

    load()


@pytest.fixture
def chip() -> Iterator[Chip]:
    made = Chip()
    yield made
    made.remove()


@pytest.fixture
def pins(chip: Chip) -> Iterator[Any]:
    from drivers.raspberrypi.pins import open_pins

    factory = open_pins()
    yield factory
    factory.close()
