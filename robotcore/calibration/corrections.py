"""Compares measured values with those of a robot's file, and writes those that differ."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Protocol

from robotcore.calibration.least_squares import Estimate

DEVIATIONS = 2.0
"""A value of the file is corrected if it differs from the measured one by more than this many standard deviations."""

MIN_SHARE = 0.001
"""A value of the file is not corrected if it differs from the measured one by less than this share."""


@dataclass(frozen=True)
class Correction:
    """A value in a robot's file, and the measured one."""

    table: tuple[str, ...]
    """The table: ``("drive",)``, ``("devices", NAME)``, or ``(SECTION, NAME)`` and the key of an inner table."""
    key: str
    old: float
    measured: Estimate
    least: float = 0.0
    """The least difference that counts, in the unit of the value."""
    is_exact: bool = False
    """Whether each difference counts, because the value follows from other corrections."""

    @property
    def is_needed(self) -> bool:
        """Whether the value of the file is wrong."""
        difference = abs(self.new - self.old)
        if self.is_exact:
            return difference > 0
        return difference > max(self.least, MIN_SHARE * abs(self.old), DEVIATIONS * self.measured.deviation)

    @property
    def new(self) -> float:
        """The measured value as it is written."""
        return self.measured.value if self.is_exact else self.measured.rounded

    @property
    def name(self) -> str:
        """The dotted name of the key, such as ``drive.track_m`` or ``left_motor.lag_s``."""
        return ".".join((*self.table[self.table[0] == "devices" :], self.key))

    def to_dict(self) -> dict[str, Any]:
        """Return the fields for JSON.

        The JSON keys:

        key: text; the dotted name in the robot's file, which ends in the unit, such as ``left_motor.lag_s``.
        old: number; the value in the file, in the unit of the key.
        new: number; the measured value as it is written.
        measured: number; the measured value.
        deviation: number; its standard deviation.
        is_needed: true or false; whether the value in the file is wrong.
        """
        return {
            "key": self.name,
            "old": self.old,
            "new": self.new,
            "measured": self.measured.value,
            "deviation": self.measured.deviation,
            "is_needed": self.is_needed,
        }


class RobotTables(Protocol):
    """The tables of a robot's file, such as a `RobotEditor`. A mapping changes keys of an inner table."""

    def set_drive(self, **values: Any) -> None:
        """Set keys of ``[drive]``."""

    def set_device(self, device: str, **values: Any) -> None:
        """Set keys in the table of ``[[devices]]`` with a name."""

    def set_section(self, section: str, device: str, **values: Any) -> None:
        """Set keys in the table of a device in a backend's section."""


def apply_corrections(tables: RobotTables, corrections: Iterable[Correction]) -> None:
    """Set the values of all needed corrections. Raises UsageError if the file lacks a table."""
    for each in corrections:
        if not each.is_needed:
            continue
        value: Any = {each.key: each.new}
        match each.table:
            case ("drive",):
                tables.set_drive(**value)
            case ("devices", name):
                tables.set_device(name, **value)
            case (section, name):
                tables.set_section(section, name, **value)
            case (section, name, inner):
                tables.set_section(section, name, **{inner: value})
