from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

FRAME_S = 1 / 30
COUNTS = 960


@dataclass
class Motor:
    """A gear motor at a duty of -255 to 255: a dead band, a speed in a line above it, a first-order lag."""

    full: float
    """Counts a frame at full duty."""
    lag_s: float
    dead: float
    speed: float = 0.0
    place: float = 0.0

    def turn(self, duty: int) -> int:
        """Turn for a frame; return how many edges its encoder has seen."""
        before = math.floor(self.place)
        goal = math.copysign(max(0.0, abs(duty) - self.dead) / (255 - self.dead) * self.full, duty)
        for _ in range(10):
            self.speed += (goal - self.speed) * (1 - math.exp(-FRAME_S / 10 / self.lag_s))
            self.place += self.speed / 10
        return math.floor(self.place) - before


def driven(motor: Motor, step: Callable[[int], int], frames: int) -> list[float]:
    """Return the speed after each frame, in counts a frame, of a motor that is given what ``step`` says."""
    counts, speeds = 0, []
    for _ in range(frames):
        counts = motor.turn(step(counts))
        speeds.append(motor.speed)
    return speeds
