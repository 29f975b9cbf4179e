"""Simulated PCA9685 chips that processes share, by doubles of a bus's device file and of the kernel's transfers.

The folder is on the PYTHONPATH of those processes. So each Python, also the guardian's, imports `sitecustomize` first.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from drivers.raspberrypi.virtual.pwm_chip import VirtualPwmChip
from tests.drivers.raspberrypi.i2c_dev import sitecustomize
from tests.drivers.raspberrypi.i2c_dev.sitecustomize import POWER_ON, reset, write

FOLDER = Path(__file__).parent
ROOT = Path(__file__).parents[4]
ADDRESS = 0x60
ALL_OFF = 0xFD
"""The register that switches every channel off."""


class Transfer(NamedTuple):
    """A transfer that wrote to a chip."""

    time: float
    """The machine's monotonic time, in seconds."""
    process: int
    register: int
    values: bytes


class Bus:
    """An I2C bus with one chip that has just got power.

    root: the folder in place of the root of the file system.
    """

    def __init__(self, root: Path, address: int = ADDRESS) -> None:
        self.root, self.folder = root, (folder := root / "dev")
        self.chip = folder / f"i2c-1.0x{address:02x}"
        folder.mkdir(parents=True, exist_ok=True)
        folder.joinpath("i2c-1").touch()
        reset(self.chip)

    @property
    def environment(self) -> dict[str, str]:
        """Return the environment of a process that uses this bus."""
        path = os.pathsep.join([str(FOLDER), str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        return {**os.environ, "PYTHONPATH": path, "FAKE_I2C": str(self.folder)}

    @property
    def registers(self) -> bytes:
        return self.chip.read_bytes()

    def duties(self) -> list[float]:
        """Return the duty of each channel."""
        return compute_duties(self.registers)

    def switch_on(self) -> None:
        """Switch every channel on, as a killed program may leave them."""
        self.chip.write_bytes(bytes([0x21, 0x04] + [0] * 4 + [0, 0x10, 0, 0] * 16 + [0] * 184 + [0x1E, 0]))

    def lose_power(self) -> None:
        """Reset the chip's registers."""
        reset(self.chip)

    def unplug(self) -> None:
        """Let the chip answer no more."""
        self.chip.unlink()

    def hang(self, seconds: float) -> None:
        """Let each transfer fail after a time, as if a chip held the bus low."""
        self.folder.joinpath("hang").write_text(str(seconds))

    def disturb(self) -> None:
        """Let the next transfer fail, as if noise had hidden the chip's answer."""
        self.folder.joinpath("noise").touch()

    def transfers(self) -> Iterator[Transfer]:
        """Yield the transfers that wrote to the chip."""
        for line in self.chip.with_suffix(".log").read_text().splitlines():
            time, process, register, values = line.split()
            yield Transfer(float(time), int(process), int(register), bytes.fromhex(values))

    def find_stop(self) -> float | None:
        """Return the time since which every channel is off. None if a channel is on."""
        registers, stop = bytearray(POWER_ON), None
        for each in self.transfers():
            write(registers, each.register, each.values)
            if any(compute_duties(registers)):
                stop = None
            elif stop is None:
                stop = each.time
        return stop


def use_bus(root: Path, patch: pytest.MonkeyPatch) -> Bus:
    """Replace /dev/i2c-1 in this process, and return the bus."""
    bus = Bus(root)
    patch.setenv("FAKE_I2C", str(bus.folder))
    patch.setattr(os, "open", sitecustomize.open_file)
    patch.setattr(os, "close", sitecustomize.close_file)
    patch.setattr("drivers.raspberrypi.i2c_device.ioctl", sitecustomize.control)
    return bus


def compute_duties(registers: bytes | bytearray) -> list[float]:
    """Return the duty of each channel for the registers of a chip."""
    chip = VirtualPwmChip()
    chip.write(0, registers[0])
    for channel in range(16):
        first = 6 + 4 * channel
        for number in range(first, first + 4):
            chip.write(number, registers[number])
    return [channel.state for channel in chip.channels]
