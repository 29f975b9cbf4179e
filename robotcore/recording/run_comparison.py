"""Compare two recordings: milestones, states, outcomes and measurements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import zip_longest
from typing import Any

from robotcore.description import WorldDescription
from robotcore.recording import Recording
from robotcore.recording.summary import (
    PosePath,
    build_odometry_path,
    build_result,
    build_true_path,
    count_interventions,
    format_settings,
    measure_path,
    measure_rate,
)
from robotcore.runtime.result import RunResult

Room = tuple[Sequence[object], ...]
"""The floor's length and width, its picture and its lines, and the outline of each object, in metres."""


def build_room(world: WorldDescription) -> Room:
    """Return the floor, its picture, its lines and the objects of a world, seen from above."""
    floor, image = world.floor, world.floor.image
    picture = (image.limits, image.content) if image else ()
    return ((floor.length_m, floor.width_m), picture, world.lines, *(thing.outline for thing in world.bodies))


_DIGITS = 4
"""The number of decimals in JSON, so that lengths are rounded to 0.1 mm."""


@dataclass(frozen=True)
class RunSummary:
    """The measurements of a recorded run. Poses are in world coordinates."""

    name: str
    recording: Recording

    @cached_property
    def result(self) -> RunResult:
        """The result of the run. If the recording has none, it is computed from the ticks."""
        return build_result(self.recording)

    @property
    def outcome(self) -> str:
        """The outcome of the run; ``cut`` or ``damaged`` if the recording has no result."""
        if self.recording.result:
            return self.result.outcome.value
        return "damaged" if self.recording.is_damaged else "cut"

    @cached_property
    def odometry(self) -> PosePath:
        """The path by odometry; empty without a drive."""
        return build_odometry_path(self.recording)

    @cached_property
    def truth(self) -> PosePath:
        """The true path; empty without a simulator."""
        return build_true_path(self.recording)

    @property
    def room(self) -> Room | None:
        """The floor, its picture, its lines and the objects of the world, seen from above; None without a world."""
        world = self.recording.metadata.world
        return build_room(world) if world else None

    @property
    def drift(self) -> float | None:
        """The distance in metres between the last pose by odometry and the true pose; None if one is unknown."""
        both = self.truth.keys() & self.odometry.keys()
        if not both:
            return None
        last = max(both)
        return self.truth[last].distance_to(*self.odometry[last][:2])

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields; an unknown value is None.

        The JSON keys:

        file: text; the file of the recording.
        app: text; the name of the app.
        backend: text; the name of the backend.
        robot: text; the name of the robot.
        world: text or null; the name of the world.
        seed: whole number or null; the seed of the run.
        settings: object of text; the settings of the app that differ from their defaults.
        faults: list of text; the injected faults.
        outcome: text; the outcome; ``cut`` or ``damaged`` if the recording has no end.
        verified: true, false or null; whether the run was a success by the true state. Null if it is unknown.
        reason: text; why the run ended.
        time_s: number, s; the robot's time at the end.
        ticks: whole number; the number of ticks.
        odometry_m: number or null, m; the length of the path by odometry.
        truth_m: number or null, m; the length of the true path.
        final_odometry: list of three numbers, m, m, rad, or null; the last pose by odometry.
        final_truth: list of three numbers, m, m, rad, or null; the last true pose.
        drift_m: number or null, m; the distance between the last pose by odometry and the true one.
        interventions: whole number; the number of times that a rule of the safety stage changed a command.
        rate_hz: number or null, Hz; the number of ticks per second.
        overruns: whole number; the number of ticks that took longer than their period.
        batteries: object; for each battery the lowest and the last voltage in V, ``lowest_v`` and ``last_v``.
        """
        result, rate = self.result, measure_rate(self.recording)
        return {
            "file": self.name,
            "app": result.app,
            "backend": result.backend,
            "robot": result.robot,
            "world": result.world,
            "seed": result.seed,
            "settings": format_settings(self.recording),
            "faults": result.faults,
            "outcome": self.outcome,
            "verified": result.verified,
            "reason": result.reason,
            "time_s": result.sim_time_s,
            "ticks": len(self.recording.ticks),
            "odometry_m": _measure_length(self.odometry),
            "truth_m": _measure_length(self.truth),
            "final_odometry": _round_last_pose(self.odometry),
            "final_truth": _round_last_pose(self.truth),
            "drift_m": None if self.drift is None else round(self.drift, _DIGITS),
            "interventions": sum(count_interventions(self.recording).values()),
            "rate_hz": None if rate is None else round(rate, _DIGITS),
            "overruns": result.overruns,
            "batteries": result.batteries,
        }


def _measure_length(path: PosePath) -> float | None:
    return round(measure_path(path.values()), _DIGITS) if path else None


def _round_last_pose(path: PosePath) -> list[float] | None:
    return [round(number, _DIGITS) for number in path[max(path)]] if path else None


DIFFERS = 1


@dataclass(frozen=True)
class StateDifference:
    """The first tick in which two runs have different states. A state is None if its run has already ended."""

    tick: int
    """The number of the tick."""
    time_s: float
    """The time of the tick on the robot's clock, in seconds."""
    first: str | None
    """The state of the first run."""
    second: str | None
    """The state of the second run."""


@dataclass(frozen=True)
class Comparison:
    """A comparison of two runs. They are alike if the order of their milestones and their outcome are equal."""

    first: RunSummary
    second: RunSummary

    @property
    def milestones(self) -> tuple[dict[str, float], dict[str, float]]:
        """The milestones of each run, in their order, with the times in seconds."""
        return self.first.result.milestones, self.second.result.milestones

    @property
    def first_other_milestone(self) -> tuple[str | None, str | None] | None:
        """The first pair of milestones that differ; None if all are equal. A missing milestone is None."""
        return next((pair for pair in zip_longest(*self.milestones) if pair[0] != pair[1]), None)

    @property
    def first_difference(self) -> StateDifference | None:
        """The first tick with different states; None if all states are equal."""
        for one, other in zip_longest(self.first.recording.ticks, self.second.recording.ticks):
            first, second = (tick.state if tick else None for tick in (one, other))
            if first != second:
                tick = one or other
                return StateDifference(tick.number, tick.time, first, second)
        return None

    @property
    def has_other_room(self) -> bool:
        """Whether the worlds of the runs differ in the floor, a line or an object; False if a world is unknown."""
        rooms = self.first.room, self.second.room
        return None not in rooms and rooms[0] != rooms[1]

    @property
    def is_alike(self) -> bool:
        return self.first_other_milestone is None and self.first.outcome == self.second.outcome

    @property
    def exit_status(self) -> int:
        return 0 if self.is_alike else DIFFERS

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields.

        The JSON keys:

        alike: true or false; whether both runs have the same milestones in the same order and the same outcome.
        first_other_milestone: list of two texts, or null; the first milestones that differ. A missing one is null.
        parting: object or null; the first tick with different states. Null if all states are equal.
        parting.*: robotcore.recording.run_comparison.StateDifference
        rooms_differ: true or false; whether the floors or the objects of the worlds differ.
        first: object; the first run.
        first.*: robotcore.recording.run_comparison.RunSummary.to_dict
        first.milestones: object of numbers, s; the time of each milestone.
        second: object; the second run, with the keys of ``first``.
        exit_status: whole number; the exit status.
        """
        first, second = self.milestones
        return {
            "alike": self.is_alike,
            "first_other_milestone": self.first_other_milestone,
            "parting": asdict(self.first_difference) if self.first_difference else None,
            "rooms_differ": self.has_other_room,
            "first": {**self.first.to_dict(), "milestones": first},
            "second": {**self.second.to_dict(), "milestones": second},
            "exit_status": self.exit_status,
        }
