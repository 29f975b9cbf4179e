"""Transfers to one chip on a simulated I2C bus."""

from __future__ import annotations

import array
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from drivers.raspberrypi.i2c_device import I2CDevice, find_bus
from tests.drivers.raspberrypi.i2c_dev import ADDRESS, Bus, use_bus


@pytest.fixture
def bus(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bus:
    return use_bus(tmp_path, monkeypatch)


@pytest.fixture
def device(bus: Bus) -> Iterator[I2CDevice]:
    with closing(I2CDevice(find_bus(1), ADDRESS)) as device:
        yield device


def test_the_kernel_copies_no_byte_beyond_the_data(device: I2CDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = set()

    def record(code: str, values: bytes) -> array.array[int]:
        sizes.add(len(values))
        return array.array(code, values)

    monkeypatch.setattr("drivers.raspberrypi.i2c_device.array", record)
    device.write(0x06, 1, 2, 3, 4)
    device.write(0x06, 5)
    assert [device.read(0x06 + at) for at in range(4)] == [5, 2, 3, 4]
    assert sizes == {34}  # union i2c_smbus_data
