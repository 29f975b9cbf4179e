"""Doubles of the registers of time-of-flight chips, for the real libraries."""

from __future__ import annotations

from tests.drivers.raspberrypi.i2c_bus import FakeChip


class FakeLaser(FakeChip):
    """The registers of a chip whose measurements have ``status`` and ``millimetres``."""

    address = 0x29

    def __init__(self, status: int, millimetres: int) -> None:
        self.status, self.millimetres = status, millimetres
        self.is_frozen = False
        self.cleared = 0
        super().__init__()

    def lose_power(self) -> None:
        super().lose_power()
        self.is_measuring = False


class FakeVL53L0X(FakeLaser):
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


class FakeVL53L1X(FakeLaser):
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
