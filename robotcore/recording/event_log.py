"""The text log of a run. Each lasting state has a line when it begins and a line when it ends."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from typing import NamedTuple

from robotcore.recording.events import RecordedError, Tick
from robotcore.runtime.faults import PlannedFault
from robotcore.runtime.result import RunResult


class Level(Enum):
    """The level of a line. The names are those of the levels in Foxglove's Log message."""

    Info = 2
    Warning = 3
    Error = 4


class LogLine(NamedTuple):
    """A line of the log."""

    level: Level
    text: str


class RunLog:
    """Lists the new events of each tick, such as a milestone, a fault or an error.

    A lasting state has a line only in the tick in which it begins and in the tick in which it ends.
    """

    def __init__(self, milestones: Iterable[str], faults: Sequence[PlannedFault] = ()) -> None:
        self._awaited = set(milestones)
        self._planned = faults
        self._present: set[int] = set()
        self._failures: dict[str, str] = {}
        self._causes: set[str] = set()
        self._dropped = 0
        self._error: RecordedError | None = None

    def list_new(self, tick: Tick) -> Iterator[LogLine]:
        """Yield the lines for the new events of a tick."""
        if tick.state in self._awaited:
            self._awaited.discard(tick.state)
            yield LogLine(Level.Info, f"milestone: {tick.state}")
        yield from self._changed_faults(tick.time)
        yield from self._changed_failures(tick)
        yield from self._changed_causes(tick)
        yield from self._drops(tick)
        yield from (LogLine(Level.Warning, warning) for warning in tick.warnings)
        yield from self._changed_error(tick.error)

    def _changed_error(self, error: RecordedError | None) -> Iterator[LogLine]:
        """Yield a line if the error differs from that of the previous tick, or if there is no error any more."""
        if error and error != self._error:
            yield LogLine(Level.Error, f"{error.kind}: {error.message}")
        if self._error and not error:
            yield LogLine(Level.Info, "the run continues")
        self._error = error

    def _changed_faults(self, time: float) -> Iterator[LogLine]:
        """Yield a line for each injected fault that begins or ends."""
        for fault in self._planned:
            if (is_on := fault.is_on(time)) is not (fault.position in self._present):
                self._present ^= {fault.position}
                yield LogLine(Level.Warning if is_on else Level.Info, f"fault {'begins' if is_on else 'ends'}: {fault}")

    def _changed_failures(self, tick: Tick) -> Iterator[LogLine]:
        failed = {read.device: read.error.message for read in tick.reads if read.error}
        for device, message in failed.items():
            if self._failures.get(device) != message:
                yield LogLine(Level.Error, message)
        for device in [name for name in self._failures if name not in failed]:
            if any(read.device == device for read in tick.reads):
                yield LogLine(Level.Info, f"{device}: returns samples again")
            else:
                failed[device] = self._failures[device]
        self._failures = failed

    def _changed_causes(self, tick: Tick) -> Iterator[LogLine]:
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

    def _drops(self, tick: Tick) -> Iterator[LogLine]:
        before, self._dropped = self._dropped, self._dropped + len(list_dropped(tick))
        if self._dropped and not before:
            yield LogLine(Level.Warning, "pictures are dropped, because the disk is too slow")


def list_dropped(tick: Tick) -> list[str]:
    """Return the devices that were read in a tick, and whose samples are missing in the recording."""
    return [read.device for read in tick.reads if read.number is None and not read.error]


def build_last_line(result: RunResult) -> LogLine:
    """Return the line for the end of a run."""
    text = f"{result.outcome.value}, {result.ticks} ticks" + (f": {result.reason}" if result.reason else "")
    return LogLine(Level.Error if result.exit_status else Level.Info, text)


def _format_wheels(wheels: tuple[float, float]) -> str:
    return "({:.2f}, {:.2f}) rad/s".format(*wheels)
