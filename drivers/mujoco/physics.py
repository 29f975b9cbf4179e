"""Physics steps: at each one touches are counted."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from drivers.mujoco.model.robot import RELEASE_M, TOUCHED
from robotcore.clock import SteppedClock

if TYPE_CHECKING:
    from mujoco import MjData, MjModel


class Physics:
    """A stepped clock whose steps are MuJoCo's.

    ``model_of`` makes the model for steps of so many seconds. Whatever `data` says is of the present: a whole
    step of MuJoCo's leaves places and contacts as they were before it, so each is taken from its middle to the next's.
    """

    def __init__(self, rate_hz: float, model_of: Callable[[float], MjModel]) -> None:
        from mujoco import MjData, mj_step1, mj_step2

        self.clock = SteppedClock(rate_hz, self._advance)
        self.model = model_of(self.clock.step)
        self.data = MjData(self.model)
        self._move, self._look_round = mj_step2, mj_step1
        self._look_round(self.model, self.data)
        self.touches = Touches(self.model, self.data)

    def _advance(self, steps: int) -> None:
        move, look_round, model, data, look = self._move, self._look_round, self.model, self.data, self.touches.look
        for _ in range(steps):
            move(model, data)
            look_round(model, data)
            look()


class Touches:
    """Counts the touches of the robot's body with things; one touch is one, however long it lasts."""

    def __init__(self, model: MjModel, data: MjData) -> None:
        self.count = 0
        self._data = data
        self._body = model.geom(TOUCHED).id
        self._floor = {geom for geom in range(model.ngeom) if model.geom(geom).name == "floor"}
        self._rolling = model.nu + 1
        self._touched: set[int] = set()

    def look(self) -> None:
        """Note what is touched after a step; wheels and caster on the floor are contacts too, and none of these."""
        data = self._data
        if data.ncon <= self._rolling and not self._touched:
            return
        gaps = self._gaps()
        begun = {thing for thing, gap in gaps.items() if gap <= 0} - self._touched
        self._touched = begun | {thing for thing in self._touched if gaps.get(thing, math.inf) <= RELEASE_M}
        self.count += len(begun)

    def _gaps(self) -> Mapping[int, float]:
        """Return how far from the body each thing is that is near, in metres."""
        contact, gaps = self._data.contact, dict[int, float]()
        for (one, other), gap in zip(contact.geom.tolist(), contact.dist.tolist(), strict=True):
            if self._body in (one, other) and not self._floor & {one, other}:
                thing = other if one == self._body else one
                gaps[thing] = min(gap, gaps.get(thing, gap))
        return gaps
