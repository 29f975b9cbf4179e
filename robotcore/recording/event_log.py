"""The text log of a run: milestones, faults, errors, interventions and dropped pictures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from typing import NamedTuple

from robotcore.recording.events import Tick
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
        self._lasting: dict[tuple[str, object], _LastingEvent] = {}
        self._has_dropped = False

    def list_new(self, tick: Tick) -> Iterator[LogLine]:
        """Yield the log lines of the next tick."""
        if tick.state in self._awaited:
            self._awaited.discard(tick.state)
            yield LogLine(Level.Info, f"milestone: {tick.state}")
        before, self._lasting = self._lasting, {each.key: each for each in self._list_lasting(tick)}
        for key, event in self._lasting.items():
            if key not in before or before[key].subject != event.subject:
                yield event.line
        for key, event in before.items():
            if key not in self._lasting:
                yield LogLine(Level.Info, event.end)
        if not self._has_dropped and list_dropped(tick):
            self._has_dropped = True
            yield LogLine(Level.Warning, "pictures are dropped, because the disk is too slow")
        yield from (LogLine(Level.Warning, warning) for warning in tick.warnings)

    def _list_lasting(self, tick: Tick) -> Iterator[_LastingEvent]:
        for fault in self._planned:
            if fault.is_active(tick.time):
                line = LogLine(Level.Warning, f"fault begins: {fault}")
                yield _LastingEvent(("fault", fault.position), line, f"fault ends: {fault}")
        read = {each.device for each in tick.reads}
        yield from (each for (kind, name), each in self._lasting.items() if kind == "device" and name not in read)
        for device, message in {each.device: each.error.message for each in tick.reads if each.error}.items():
            line = LogLine(Level.Error, message)
            yield _LastingEvent(("device", device), line, f"{device}: returns samples again", message)
        for cause, each in {each.cause: each for each in reversed(tick.interventions)}.items():
            change = f"{cause}: {_format_wheels(each.asked)} became {_format_wheels(each.sent)}"
            yield _LastingEvent(("cause", cause), LogLine(Level.Warning, change), f"{cause}: ended")
        if error := tick.error:
            line = LogLine(Level.Error, f"{error.kind}: {error.message}")
            yield _LastingEvent(("error", ""), line, "the run continues", error)


class _LastingEvent(NamedTuple):
    key: tuple[str, object]
    line: LogLine
    """The line at the beginning of the event, and each time its subject changes."""
    end: str
    subject: object = None


def list_dropped(tick: Tick) -> list[str]:
    """Return the device of each read in a tick whose picture was dropped."""
    return [read.device for read in tick.reads if read.number is None and not read.error]


def build_last_line(result: RunResult) -> LogLine:
    """Return the last log line of a run: its headline, its number of ticks and the reason."""
    text = f"{result.headline}, {result.ticks} ticks" + (f": {result.reason}" if result.reason else "")
    return LogLine(Level.Error if result.exit_status else Level.Info, text)


def _format_wheels(wheels: tuple[float, float]) -> str:
    return "({:.2f}, {:.2f}) rad/s".format(*wheels)
