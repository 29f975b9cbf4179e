"""Where a robot went, and in which state it was there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import groupby
from typing import NamedTuple

from robotcore.geometry import Pose


class Footstep(NamedTuple):
    """The true pose at a tick, and the state that was then decided."""

    time: float
    state: str
    pose: Pose


class Track:
    """The footsteps of a run, in order."""

    def __init__(self) -> None:
        self.steps: list[Footstep] = []

    @property
    def states(self) -> list[str]:
        """Every state that occurred, in the order of its first time."""
        return list(dict.fromkeys(step.state for step in self.steps))

    def stretches(self) -> Iterator[tuple[str, list[Footstep]]]:
        """Yield the stretches of one state each; one begins where the one before it ends."""
        last: list[Footstep] = []
        for state, steps in groupby(self.steps, key=lambda step: step.state):
            stretch = [*last, *steps]
            yield state, stretch
            last = stretch[-1:]

    def spells(self) -> Iterator[tuple[str, float, float]]:
        """Yield for each state when it was reached first and how long it lasted in all, in seconds."""
        for state in self.states:
            stretches = [steps for name, steps in self.stretches() if name == state]
            first = next(step.time for step in stretches[0] if step.state == state)
            yield state, first, sum(steps[-1].time - steps[0].time for steps in stretches)

    def places(self, milestones: Mapping[str, float]) -> dict[str, Pose]:
        """Return where the robot was when it reached each milestone, ``milestones`` being their times.

        One that was no state of it is left out.
        """
        states = set(self.states)
        return {
            name: min(self.steps, key=lambda step: abs(step.time - time)).pose
            for name, time in milestones.items()
            if name in states
        }
