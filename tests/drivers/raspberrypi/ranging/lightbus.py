"""Doubles of an I2C bus and of the registers of time-of-flight chips, for the real libraries."""

from __future__ import annotations

import errno
from abc import ABC, abstractmethod
from collections import Counter

ADDRESS = 0x29


class FakeChip(ABC):
    """The registers of a chip whose measurements have ``status`` and ``millimetres``."""

    width: int
    """The number of bytes of a register's number."""

    def __init__(self, status: int, millimetres: int) -> None:
        self.status, self.millimetres = status, millimetres
        self.is_plugged_in, self.is_frozen = True, False
        self.cleared = 0
        self.lose_power()

    def lose_power(self) -> None:
        """Reset the registers, as after a loss of power."""
        self.registers: Counter[int] = Counter()
        self.pointer = 0
        self.is_measuring = False

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


class FakeVL53L0X(FakeChip):
    """A VL53L0X, whose register 0xFF selects a page of registers."""

    width = 1
    _PAGE = 0xFF

    def get(self, register: int) -> int:
        known = {0xC0: 0xEE, 0xC1: 0xAA, 0xC2: 0x10, 0x14: self.status << 3 | 1}
        known |= {0x1E: self.millimetres >> 8, 0x1F: self.millimetres & 0xFF}
        known |= {0x13: 0 if self.is_frozen and self.is_measuring else 4}
        if self.registers[self._PAGE] == 0 and register in known:
            return known[register]
        return 1 if register == 0x83 else self.registers[self.registers[self._PAGE] << 8 | register]

    def set(self, register: int, value: int) -> None:
        page = self.registers[self._PAGE]
        if register == self._PAGE:
            self.registers[self._PAGE] = value
        elif (page, register) == (0, 0x00):
            self.is_measuring = value == 0x02  # the bits of a single measurement fall by themselves
        else:
            self.registers[page << 8 | register] = value
            self.cleared += (page, register) == (0, 0x0B)


class FakeVL53L1X(FakeChip):
    width = 2

    def get(self, register: int) -> int:
        known = {0x010F: 0xEA, 0x0110: 0xCC, 0x0111: 0x10, 0x0031: self.is_measuring and not self.is_frozen}
        known |= {0x0089: 0xE0 | self.status, 0x0096: self.millimetres >> 8, 0x0097: self.millimetres & 0xFF}
        return int(known.get(register, self.registers[register]))

    def set(self, register: int, value: int) -> None:
        self.registers[register] = value
        if register == 0x0087:
            self.is_measuring = value == 0x40
        self.cleared += (register, value) == (0x0086, 1)


class FakeBus:
    """A double of Blinka's bus. At an address without a chip it raises the kernel's error."""

    def __init__(self, chip: FakeChip) -> None:
        self.chip = chip
        self.is_open = False

    def open(self, number: int, frequency: int | None) -> FakeBus:
        assert (number, frequency) == (1, None)
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

    def _require(self, address: int) -> None:
        if address != ADDRESS or not self.chip.is_plugged_in or not self.is_open:
            raise OSError(errno.EREMOTEIO, "Remote I/O error")
