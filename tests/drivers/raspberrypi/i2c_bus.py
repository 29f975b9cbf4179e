"""Doubles of an I2C bus and of a chip's registers, for the real libraries."""

from __future__ import annotations

import errno
from abc import ABC, abstractmethod
from collections import Counter

import pytest

from robotcore.description import load_robot
from robotcore.hal.clock import SteppedClock
from robotcore.hardware import DeviceContext


class FakeChip(ABC):
    """The registers of a chip."""

    address: int
    width: int
    """The number of bytes of a register's number."""

    def __init__(self) -> None:
        self.is_plugged_in = True
        self.lose_power()

    def lose_power(self) -> None:
        """Reset the registers, as after a loss of power."""
        self.registers: Counter[int] = Counter()
        self.pointer = 0

    def write(self, data: bytes) -> None:
        self.pointer = int.from_bytes(data[: self.width], "big")
        for value in data[self.width :]:
            self.set(self.pointer, value)
            self.pointer += 1

    def read(self, count: int) -> bytes:
        start, self.pointer = self.pointer, self.pointer + count
        return bytes(self.get(register) for register in range(start, start + count))

    @abstractmethod
    def get(self, register: int) -> int: ...

    @abstractmethod
    def set(self, register: int, value: int) -> None: ...


class FakeBus:
    """A double of Blinka's bus. At an address without a chip it raises the kernel's error."""

    def __init__(self, chip: FakeChip) -> None:
        self.chip = chip
        self.is_open = False

    def open(self, number: int, frequency: int | None) -> FakeBus:
        assert number in (1, 3)
        assert frequency is None
        self.is_open = True
        return self

    def deinit(self) -> None:
        self.is_open = False

    def try_lock(self) -> bool:
        return True

    def unlock(self) -> None: ...

    def writeto(self, address: int, buffer: bytes, *, start: int = 0, end: int | None = None) -> None:
        self._require(address)
        self.chip.write(bytes(buffer[start:end]))

    def readfrom_into(self, address: int, buffer: bytearray, *, start: int = 0, end: int | None = None) -> None:
        self._require(address)
        count = len(buffer[start:end])
        buffer[start : start + count] = self.chip.read(count)

    def writeto_then_readfrom(
        self,
        address: int,
        out: bytes,
        into: bytearray,
        *,
        out_start: int = 0,
        out_end: int | None = None,
        in_start: int = 0,
        in_end: int | None = None,
    ) -> None:
        self.writeto(address, out, start=out_start, end=out_end)
        self.readfrom_into(address, into, start=in_start, end=in_end)

    def _require(self, address: int) -> None:
        if address != self.chip.address or not self.chip.is_plugged_in or not self.is_open:
            raise OSError(errno.EREMOTEIO, "Remote I/O error")


class ChipBench:
    """A chip on a bus, which Adafruit's libraries open, and a clock with steps of 1 ms."""

    def __init__(self, chip: FakeChip, patch: pytest.MonkeyPatch) -> None:
        self.bus = FakeBus(chip)
        self.clock = SteppedClock(1000, lambda _steps: None)
        patch.setattr("adafruit_extended_bus.ExtendedI2C", self.bus.open)

    @property
    def context(self) -> DeviceContext:
        """A new context to open the chip's driver with."""
        return DeviceContext(load_robot("rover"), self.clock)
