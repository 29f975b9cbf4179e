"""Where a run of a sweep was."""

from __future__ import annotations

from typing import NamedTuple

from robotcore.sweep.record import Record


class Place(NamedTuple):
    """A backend and a world; the latter is empty where a backend has none."""

    backend: str
    world: str

    @classmethod
    def of(cls, record: Record) -> Place:
        """Return where a run was."""
        return cls(record.result.backend, record.result.world or "")

    def __str__(self) -> str:
        return f"in {self.world} on {self.backend}" if self.world else f"on {self.backend}"
