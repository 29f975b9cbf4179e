"""One of two recordings that are compared: what it is measured by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from robotcore.geometry import Pose
from robotcore.recording import Recording
from robotcore.recording.contents import interventions_of, rate_of
from robotcore.recording.ended import result_of
from robotcore.recording.path import Path, length_of, odometry_path, true_path
from robotcore.runtime.outcome import RunResult

Room = tuple[Sequence[object], ...]
"""The sides of the floor, and the outline of each thing, in metres."""

_DIGITS = 4
"""A tenth of a millimetre."""


@dataclass(frozen=True)
class Side:
    """A recording and what it is called; lengths in metres, poses in the world, rates in Hz."""

    name: str
    recording: Recording

    @cached_property
    def result(self) -> RunResult:
        """How it ended; of a file that was cut, what is known."""
        return result_of(self.recording)

    @property
    def outcome(self) -> str:
        """What the run came to; of a file that was cut or damaged before that, so much."""
        if self.recording.result:
            return self.result.outcome.value
        return "damaged" if self.recording.is_damaged else "cut"

    @cached_property
    def odometry(self) -> Path:
        """Where the wheels took the robot."""
        return odometry_path(self.recording)

    @cached_property
    def truth(self) -> Path:
        """Where it was, where a simulator tells."""
        return true_path(self.recording)

    @property
    def room(self) -> Room | None:
        """What stands where, as seen from above; None where no world was described."""
        world = self.recording.metadata.world
        if world is None:
            return None
        return ((world.floor.length_m, world.floor.width_m), *(thing.outline for thing in world.things))

    @property
    def path(self) -> list[Pose]:
        """The true path, else the odometry's."""
        return list((self.truth or self.odometry).values())

    @property
    def rate_hz(self) -> float | None:
        """How many ticks a second there were, on the robot's clock."""
        return rate_of(self.recording)

    @property
    def interventions(self) -> int:
        return sum(interventions_of(self.recording).values())

    @property
    def drift(self) -> float | None:
        """How far the odometry is from the truth in the end."""
        both = self.truth.keys() & self.odometry.keys()
        if not both:
            return None
        last = max(both)
        return self.truth[last].distance_to(*self.odometry[last][:2])

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON tells of it; null is what nobody knows."""
        result = self.result
        return {
            "file": self.name,
            "app": result.app,
            "backend": result.backend,
            "robot": result.robot,
            "world": result.world,
            "seed": result.seed,
            "outcome": self.outcome,
            "verified": result.verified,
            "reason": result.reason,
            "time_s": result.sim_time_s,
            "ticks": len(self.recording.ticks),
            "odometry_m": _length(self.odometry),
            "truth_m": _length(self.truth),
            "final_odometry": _last(self.odometry),
            "final_truth": _last(self.truth),
            "drift_m": None if self.drift is None else round(self.drift, _DIGITS),
            "interventions": self.interventions,
            "rate_hz": None if self.rate_hz is None else round(self.rate_hz, _DIGITS),
            "overruns": result.overruns,
            "batteries": result.batteries,
        }


def _length(path: Path) -> float | None:
    return round(length_of(path.values()), _DIGITS) if path else None


def _last(path: Path) -> list[float] | None:
    return [round(number, _DIGITS) for number in path[max(path)]] if path else None
