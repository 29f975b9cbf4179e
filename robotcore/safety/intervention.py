"""What the safety stage changed."""

from __future__ import annotations

from dataclasses import dataclass

from robotcore.geometry import Wheels

REST = Wheels(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Intervention:
    """The stage changed a command: when, by which rule, and what became of it."""

    time: float
    cause: str
    asked: Wheels
    sent: Wheels
