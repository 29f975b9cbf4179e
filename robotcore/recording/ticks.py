"""Makes ticks of what was noted."""

from __future__ import annotations

from collections.abc import Iterable

from robotcore.description import RobotDescription
from robotcore.geometry import DifferentialGeometry, Pose, Wheels
from robotcore.hal.drive import Odometry
from robotcore.recording.events import Raised, Tick, Turned
from robotcore.recording.notes import Notes
from robotcore.runtime.trace import TickRecord


class Ticks:
    """The ticks of one run, made in turn."""

    def __init__(self, description: RobotDescription) -> None:
        self._path = Path(description.drive.geometry) if description.drive else None

    def made_of(self, record: TickRecord, notes: Notes, error: Raised | None) -> Tick:
        """Return a tick as it is recorded; ``error`` is what ended the run in it."""
        return Tick(
            number=record.tick,
            time=record.time,
            state=record.state,
            reads=tuple(notes.reads),
            asks=tuple(notes.asks),
            motor_asks=tuple(notes.motor_asks),
            turned=tuple(notes.turned),
            standing=tuple(notes.standing),
            pose=self._path.after(notes.turned) if self._path and notes.turned else None,
            asked=record.asked,
            sent=record.sent,
            interventions=record.interventions,
            commit_error=notes.commit_error,
            shown=tuple(notes.shown),
            error=error,
            warnings=record.warnings,
        )


class Path:
    """Where the wheels' angles took the robot: the drive's own odometry, over the angles that it read."""

    def __init__(self, geometry: DifferentialGeometry) -> None:
        self._angles = Wheels(0.0, 0.0)
        self._odometry = Odometry(geometry, lambda: self._angles)
        self._pose = Pose(0.0, 0.0, 0.0)

    def after(self, turned: Iterable[Turned]) -> Pose:
        """Return the pose after what the odometry read in a tick."""
        for each in turned:
            if each.angles:
                self._angles = each.angles
                self._pose = self._odometry.pose()
        return self._pose
