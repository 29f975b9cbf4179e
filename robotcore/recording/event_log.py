"""The text log of a run: milestones, faults, errors, interventions and dropped pictures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from typing import NamedTuple

from robotcore.recording.events import RecordedError, Tick
from robotcore.runtime.faults import PlannedFault
from robotcore.runtime.result import RunResult


class Level(Enum):
    """The level of a log line, with the names of Foxglove's log levels."""

    Info = 2
    Warning = 3
    Error = 4


class LogLine(NamedTuple):
    """A line of the text log."""

    level: Level
    text: str


class RunLog:
    """Yields the log lines of each tick.

    A fault, an error or an intervention that lasts for many ticks has one line when it begins and one when it ends.
    """

    def __init__(self, milestones: Iterable[str], faults: Sequence[PlannedFault] = ()) -> None:
        self._awaited = set(milestones)
        self._planned = faults
        self._present: set[int] = set()
        self._device_errors: dict[str, str] = {}
        self._causes: set[str] = set()
        self._dropped = 0
        self._error: RecordedError | None = None

    def list_new(self, tick: Tick) -> Iterator[LogLine]:
        """Yield the log lines of the next tick."""
        if tick.state in self._awaited:
            self._awaited.discard(tick.state)
            yield LogLine(Level.Info, f"milestone: {tick.state}")
        yield from self._list_fault_changes(tick.time)
        yield from self._list_device_errors(tick)
        yield from self._list_interventions(tick)
        yield from self._list_drops(tick)
        yield from (LogLine(Level.Warning, warning) for warning in tick.warnings)
        yield from self._list_error_changes(tick.error)

    def _list_error_changes(self, error: RecordedError | None) -> Iterator[LogLine]:
        if error and error != self._error:
            yield LogLine(Level.Error, f"{error.kind}: {error.message}")
        if self._error and not error:
            yield LogLine(Level.Info, "the run continues")
        self._error = error

    def _list_fault_changes(self, time: float) -> Iterator[LogLine]:
        for fault in self._planned:
            if (is_on := fault.is_on(time)) is not (fault.position in self._present):
                self._present ^= {fault.position}
                yield LogLine(Level.Warning if is_on else Level.Info, f"fault {'begins' if is_on else 'ends'}: {fault}")

    def _list_device_errors(self, tick: Tick) -> Iterator[LogLine]:
        failed = {read.device: read.error.message for read in tick.reads if read.error}
        for device, message in failed.items():
            if self._device_errors.get(device) != message:
                yield LogLine(Level.Error, message)
        for device in [name for name in self._device_errors if name not in failed]:
            if any(read.device == device for read in tick.reads):
                yield LogLine(Level.Info, f"{device}: returns samples again")
            else:
                failed[device] = self._device_errors[device]
        self._device_errors = failed

    def _list_interventions(self, tick: Tick) -> Iterator[LogLine]:
        causes = {each.cause for each in tick.interventions}
        for each in tick.interventions:
            if each.cause not in self._causes:
                self._causes.add(each.cause)
                yield LogLine(
                    Level.Warning, f"{each.cause}: {_format_wheels(each.asked)} became {_format_wheels(each.sent)}"
                )
        for cause in sorted(self._causes - causes):
            yield LogLine(Level.Info, f"{cause}: ended")
        self._causes = causes

    def _list_drops(self, tick: Tick) -> Iterator[LogLine]:
        before, self._dropped = self._dropped, self._dropped + len(list_dropped(tick))
        if self._dropped and not before:
            yield LogLine(Level.Warning, "pictures are dropped, because the disk is too slow")


def list_dropped(tick: Tick) -> list[str]:
    """Return the device of each read in a tick whose picture was dropped."""
    return [read.device for read in tick.reads if read.number is None and not read.error]


def build_last_line(result: RunResult) -> LogLine:
    """Return the last log line of a run: its headline, its number of ticks and the reason."""
    text = f"{result.headline}, {result.ticks} ticks" + (f": {result.reason}" if result.reason else "")
    return LogLine(Level.Error if result.exit_status else Level.Info, text)


def _format_wheels(wheels: tuple[float, float]) -> str:
    return "({:.2f}, {:.2f}) rad/s".format(*wheels)
