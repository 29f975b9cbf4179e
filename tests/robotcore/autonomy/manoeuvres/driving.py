"""An app that runs a routine, and the true poses of its run."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from robotcore import Behaviour, Robot, Role, Routine, RunRequest, Status, run
from robotcore.geometry import Pose, Wheels, wrap_angle
from robotcore.kinds import Bumper, Imu
from robotcore.runtime.observer import RunContext
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord

Route = Callable[[Robot], Routine[Any]]


class RoutineApp(Behaviour):
    """Runs a routine, and keeps its result."""

    needs = frozenset({Role.DRIVE})
    wants = frozenset({Role.RANGE, Bumper, Imu})

    def __init__(self, build: Route) -> None:
        self._build = build
        self.result: Any = None

    def run(self, robot: Robot) -> Routine[Status]:
        self.result = yield from self._build(robot)
        return Status.SUCCESS


class TrueWay:
    """An observer that stores the true pose at the start and in each tick, and the commands."""

    def __init__(self) -> None:
        self.poses: list[Pose] = []
        self.records: list[TickRecord] = []

    def begin(self, context: RunContext) -> None:
        assert context.truth
        self._truth = context.truth
        self.poses.append(self._truth.pose)

    def tick(self, record: TickRecord) -> None:
        self.poses.append(self._truth.pose)
        self.records.append(record)

    def end(self, result: RunResult) -> None: ...


class Drive(NamedTuple):
    """A run of a routine."""

    result: RunResult
    returned: Any
    """The result of the routine."""
    way: TrueWay

    @property
    def sent(self) -> list[Wheels]:
        """The commands that were sent, in rad/s."""
        return [record.sent for record in self.way.records if record.sent]

    @property
    def end(self) -> Pose:
        """The true pose at the end, in the frame of the start."""
        first, last = self.way.poses[0], self.way.poses[-1]
        return Pose(*first.to_local(last.x, last.y), wrap_angle(last.heading - first.heading))


def drive(build: Route, **request: Any) -> Drive:
    """Run a routine in a simulator, by default on open ground."""
    app, way = RoutineApp(build), TrueWay()
    result = run(RunRequest(app, **{"world": "open", **request}), [way])
    return Drive(result, app.result, way)


def is_at(pose: Pose, goal: Pose, distance: float = 0.003, angle: float = math.radians(0.3)) -> bool:
    """Return whether a pose is near a goal."""
    return pose.distance_to(goal.x, goal.y) < distance and abs(wrap_angle(pose.heading - goal.heading)) < angle
