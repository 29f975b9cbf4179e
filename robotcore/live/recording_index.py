"""The content of a recording at each tick: samples, pictures, commands, values, log lines and the path."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, Generic, TypeVar

from robotcore.errors import RobotcoreError
from robotcore.live.snapshot import PATH_STEP_M
from robotcore.recording import Recording, SampleKey, Tick
from robotcore.recording.event_log import Level, LogLine, RunLog, build_last_line, list_dropped
from robotcore.recording.summary import build_odometry_path, build_true_path
from robotcore.runtime.faults import PlannedFault, plan_faults
from robotcore.safety.velocity_limits import AccelerationLimit

T = TypeVar("T")


class Series(Generic[T]):
    """Values in the order of the ticks at which they came.

    >>> series = Series()
    >>> series.add(2, "a"), series.add(5, "b"), series.add(5, "c")
    (None, None, None)
    >>> [series.find(at) for at in (1, 2, 4, 5)]
    [None, 'a', 'a', 'c']
    >>> series.list_between(3, 5)
    ['b', 'c']
    """

    def __init__(self) -> None:
        self._ticks: list[int] = []
        self._values: list[T] = []

    def add(self, at: int, value: T) -> None:
        """Add a value at the last tick or a later one."""
        self._ticks.append(at)
        self._values.append(value)

    def find(self, at: int) -> T | None:
        """Return the newest value at a tick; None if the series begins later."""
        index = bisect_right(self._ticks, at)
        return self._values[index - 1] if index else None

    def list_between(self, first: int, last: int) -> list[T]:
        """Return the values from a tick to another, both included."""
        return self._values[bisect_right(self._ticks, first - 1) : bisect_right(self._ticks, last)]


class RecordingIndex:
    """Finds the content of a recording at a tick. A tick is named by its place in the recording, from 0.

    It has keys of pictures, and no picture.

    cameras: the names of the cameras.
    """

    def __init__(self, recording: Recording, cameras: Collection[str]) -> None:
        self._recording = recording
        self.samples: dict[str, Series[SampleKey]] = {}
        """The samples of each sensor."""
        self.pictures: dict[str, Series[SampleKey]] = {}
        """The pictures of each camera and each display."""
        self.commands: dict[str, Series[Any]] = {}
        """The commands to each actuator other than motors of the drive and displays."""
        self.logged: dict[str, Series[Any]] = {}
        """The values that the app logged."""
        self.milestones: dict[str, float] = {}
        """The time in seconds at which the app reached each milestone."""
        self.lines: Series[dict[str, Any]] = Series()
        """The lines of the log, as messages of the page."""
        self.path: Series[tuple[float, float, str]] = Series()
        """The points of the path, each with the state of the app."""
        self.dropped = 0
        """The number of pictures that the recording lacks, because the disk was too slow."""
        self.truth = build_true_path(recording)
        """The true poses by tick number; empty if no simulator measured them."""
        self.faults = _plan_faults(recording)
        """The faults of the run."""
        log = RunLog(recording.metadata.milestones, self.faults)
        state = ""
        for at, tick in enumerate(recording.ticks):
            self._add_samples(at, tick, cameras)
            self._add_values(at, tick)
            self._add_lines(at, tick, log, is_new_state=tick.state != state)
            state = tick.state
        self._add_path()

    def _add_samples(self, at: int, tick: Tick, cameras: Collection[str]) -> None:
        samples = self._recording.samples
        for key in (each.key for each in tick.reads):
            if key and key in samples:
                self.samples.setdefault(key.device, Series()).add(at, key)
                if key.device in cameras:
                    self.pictures.setdefault(key.device, Series()).add(at, key)
        for key in (each.key for each in tick.shown):
            if key and key in samples:
                self.pictures.setdefault(key.device, Series()).add(at, key)
        self.dropped += len(list_dropped(tick))

    def _add_values(self, at: int, tick: Tick) -> None:
        for command in tick.list_commands():
            if command.error is None:
                self.commands.setdefault(command.device, Series()).add(at, command.given)
        for name, value in self._recording.logged.get(tick.number, {}).items():
            self.logged.setdefault(name, Series()).add(at, value)
        if tick.state in self._recording.metadata.milestones:
            self.milestones.setdefault(tick.state, round(tick.time, 3))

    def _add_lines(self, at: int, tick: Tick, log: RunLog, *, is_new_state: bool) -> None:
        lines = [LogLine(Level.Info, f"state: {tick.state}")] if is_new_state else []
        named = tuple(each for each in tick.interventions if each.cause != AccelerationLimit.cause)
        lines += log.list_new(replace(tick, interventions=named))
        lines += [LogLine(Level.Info, text) for text in self._recording.printed.get(tick.number, ())]
        if at == len(self._recording.ticks) - 1 and (result := self._recording.result):
            lines.append(build_last_line(result))
        for level, text in lines:
            self.lines.add(at, {"type": "line", "level": level.name, "time": round(tick.time, 3), "text": text})

    def _add_path(self) -> None:
        poses, last = self.truth or build_odometry_path(self._recording), None
        for at, tick in enumerate(self._recording.ticks):
            pose = poses.get(tick.number)
            if pose and not self.truth:
                pose = tick.pose  # relative to the start, as the page shows a run on a robot
            if pose and (last is None or pose.distance_to(last.x, last.y) >= PATH_STEP_M):
                last = pose
                self.path.add(at, (round(pose.x, 4), round(pose.y, 4), tick.state))


def _plan_faults(recording: Recording) -> Sequence[PlannedFault]:
    metadata = recording.metadata
    with suppress(RobotcoreError):  # the fault may be of a package that is not installed
        return plan_faults(metadata.request.faults, metadata.description, metadata.devices)
    return ()
