"""An app that fails on purpose in a given tick: it raises, commands NaN, or gives up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from apps.green_search import GreenSearch
from robotcore.autonomy.routines import Routine, race
from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Status


@dataclass
class ClumsySearch(GreenSearch):
    """Searches as green-search does, and fails in tick ``at``."""

    at: int = 50
    by: Literal["raise", "nan"] = "raise"

    def run(self, robot: Robot) -> Routine[Status]:
        yield from race(self._fail(robot), super().run(robot))
        return Status.SUCCESS

    def _fail(self, robot: Robot) -> Routine[None]:
        for _ in range(self.at):
            yield
        if self.by == "raise":
            raise ArithmeticError(f"no more, at {robot.clock.now():g} s")
        robot.drive.set_wheels(math.nan, 1.0)
