"""A PCA9685 on the tests' simulated bus."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.drivers.raspberrypi.i2c_dev import Bus, use_bus


@pytest.fixture
def bus(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bus:
    """Replace /dev/i2c-1 in this process, and return the bus."""
    return use_bus(tmp_path, monkeypatch)
