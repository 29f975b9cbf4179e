"""Two wheels behind a board."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

LAG_S = 0.05


@dataclass
class Wheel:
    """Turns towards the velocity that it is told, with a first-order lag; rad and rad/s."""

    told: float = 0.0
    velocity: float = 0.0
    angle: float = 0.0

    def turn(self, seconds: float) -> None:
        """Let time pass."""
        kept = math.exp(-seconds / LAG_S)
        lagging = self.velocity - self.told
        self.angle += self.told * seconds + lagging * LAG_S * (1 - kept)
        self.velocity = self.told + lagging * kept


@dataclass
class Wheels:
    """The left and the right wheel."""

    left: Wheel = field(default_factory=Wheel)
    right: Wheel = field(default_factory=Wheel)

    def tell(self, left: float, right: float) -> None:
        self.left.told, self.right.told = left, right

    def turn(self, seconds: float) -> None:
        self.left.turn(seconds)
        self.right.turn(seconds)
