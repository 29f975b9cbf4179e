"""Transfers to one chip on a simulated I2C bus."""

from __future__ import annotations

import array
import errno
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from drivers.raspberrypi.i2c_device import I2CDevice, find_bus
from tests.drivers.raspberrypi.i2c_dev import ADDRESS, Bus, use_bus
from tests.drivers.raspberrypi.i2c_dev.sitecustomize import control


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
    device.write(0x00, 0x20)  # the chip increments the number of a register
    device.write(0x06, 1, 2, 3, 4)
    device.write(0x06, 5)
    assert [device.read(0x06 + at) for at in range(4)] == [5, 2, 3, 4]
    assert sizes == {34}  # union i2c_smbus_data


def test_transfer_that_noise_disturbed_is_repeated_once(bus: Bus, device: I2CDevice) -> None:
    bus.disturb()
    device.write(0x06, 5)
    bus.disturb()
    assert device.read(0x06) == 5
    bus.unplug()
    with pytest.raises(OSError, match="Remote I/O"):
        device.read(0x06)


def test_transfer_on_a_hung_bus_is_not_repeated(bus: Bus, device: I2CDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    bus.hang(0.0)
    tries = []

    def send(file: int, request: int, argument: bytes) -> None:
        tries.append(argument)
        control(file, request, argument)

    monkeypatch.setattr("drivers.raspberrypi.i2c_device.ioctl", send)
    with pytest.raises(TimeoutError):
        device.read(0x06)
    assert len(tries) == 1


def test_closed_device_writes_to_no_file_that_gets_its_number(bus: Bus) -> None:
    closed = I2CDevice(find_bus(1), ADDRESS)
    closed.close()
    with closing(I2CDevice(find_bus(1), ADDRESS)), pytest.raises(OSError, match=os.strerror(errno.EBADF)):
        closed.write(0x06, 5)
    assert list(bus.transfers()) == []


FORKING = """
import os, sys
from drivers.raspberrypi.i2c_device import I2CDevice, find_bus
device = I2CDevice(find_bus(1), int(sys.argv[1]))
device.reserve()
if os.fork():
    os._exit(0)
print("forked", flush=True)
sys.stdin.read()
"""


def test_a_fork_of_an_ended_program_does_not_keep_the_chip_reserved(bus: Bus, device: I2CDevice) -> None:
    command, pipe = [sys.executable, "-c", FORKING, str(ADDRESS)], subprocess.PIPE
    with subprocess.Popen(command, env=bus.environment, stdin=pipe, stdout=pipe) as program:
        assert program.stdout
        assert program.stdout.readline() == b"forked\n"
        program.wait()
        assert not device.is_reserved()
