"""The record of one run of a sweep: the observer of its path, and its line of JSON in the results file."""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple, get_type_hints

from pydantic import ConfigDict, ValidationError, create_model

from robotcore.runtime.result import Outcome, RunResult
from robotcore.text import pluralize

if TYPE_CHECKING:
    from robotcore.hal.truth import Truth
    from robotcore.runtime.session import RunContext
    from robotcore.runtime.trace import TickRecord


MAX_RESULT_TEXT = 2000
"""The maximum length of a reason or a note in a record, in characters. The text of an exception may be very long."""

MAX_NOTES = 100
"""The maximum number of notes in a record."""

TruePath = tuple[tuple[float, float, float], ...]
"""The true positions of the robot during a run: points (t, x, y) in seconds and metres, in the order of time."""

_SURROGATE = re.compile("[\ud800-\udfff]")

INTERVAL_S = 0.5
"""The time between two points of a `TruePath`, in seconds."""

_EARLY_S = 1e-6
"""The tolerance for the time of a tick, in seconds. The time is a sum of steps, so rounding may make it too small."""


@dataclass(frozen=True)
class Record:
    """A finished run of a sweep.

    >>> from robotcore import Outcome, RunResult
    >>> result = RunResult("search", "kinematic", "rover", "arena", 7, Outcome.TIMEOUT, 1, "not done after 60 s")
    >>> record = Record(result, None, "robotcore run search --seed 7")
    >>> record.is_failure
    True
    >>> Record.from_json(record.to_json()) == record
    True
    """

    result: RunResult
    """The result of the run."""

    path: TruePath | None
    """The robot's true path; None if the backend has no true pose."""

    command: str
    """The shell command that repeats the run."""

    picture: str | None = None
    """The file name of the picture of a failing run, relative to the sweep's folder; None if the run has no picture."""

    @property
    def is_failure(self) -> bool:
        """Whether the run counts as failing.

        A run fails if its outcome is not ``success``, if the judge or the simulator disputes it, or if the robot had
        a contact. A run that cannot be verified may pass.
        """
        result = self.result
        return result.outcome is not Outcome.SUCCESS or result.verified is False or bool(result.contacts)

    def to_json(self) -> str:
        """Return the record as one line of JSON: the keys of the result, then ``command``, ``path`` and ``picture``.

        JSON has no NaN and no infinity, so such a number becomes null. A point of the path with such a number is left
        out. A lone surrogate in a text is escaped.
        """
        payload = json.loads(self.result.to_json(), parse_constant=lambda _: None)
        path = self.path and [point for point in self.path if all(map(math.isfinite, point))]
        payload.update(command=self.command, path=path, picture=self.picture)
        line = json.dumps(payload, allow_nan=False, ensure_ascii=False)
        return _SURROGATE.sub(lambda found: rf"\\u{ord(found[0]):x}", line)

    @classmethod
    def from_json(cls, line: str | bytes) -> Record:
        """Return the record in a line of `to_json`. Raises ValueError if the line is not a record."""
        try:
            values = vars(_Line.model_validate_json(line.strip()))
        except ValidationError as error:
            raise ValueError("it is not the record of a run") from error
        return cls(
            path=values.pop("path"),
            command=values.pop("command"),
            picture=values.pop("picture"),
            result=RunResult(**values),
        )


def shorten(result: RunResult) -> RunResult:
    """Return the result with a shortened reason and shortened notes, by `MAX_RESULT_TEXT` and `MAX_NOTES`.

    >>> short = shorten(RunResult("a", "b", "c", None, 1, Outcome.ERROR, 5, reason="x" * 2500))
    >>> short.reason[-26:]
    'xxx… (500 more characters)'
    """
    notes = [_truncate(note) for note in result.notes[:MAX_NOTES]]
    if (more := len(result.notes) - MAX_NOTES) > 0:
        notes.append(f"… ({more} more notes)")
    return replace(result, reason=_truncate(result.reason), notes=notes)


def _truncate(text: str) -> str:
    more = len(text) - MAX_RESULT_TEXT
    return f"{text[:MAX_RESULT_TEXT]}… ({more} more characters)" if more > 0 else str(text)


_hints = get_type_hints(RunResult) | get_type_hints(Record)
_required: dict[str, Any] = {name: (hint, ...) for name, hint in _hints.items() if name not in ("result", "error")}
_Line = create_model("_Line", __config__=ConfigDict(strict=True, allow_inf_nan=False), **_required)
"""The pydantic model of a line of JSON. It requires every field of `RunResult` and `Record`."""


class GroupKey(NamedTuple):
    """The backend and the world of a group of runs of a sweep."""

    backend: str
    """The name of the backend."""

    world: str
    """The name of the world; empty if the backend has no world."""

    @classmethod
    def from_record(cls, record: Record) -> GroupKey:
        """Return the backend and the world of a record's run."""
        return cls(record.result.backend, record.result.world or "")

    def __str__(self) -> str:
        return f"in {self.world} on {self.backend}" if self.world else f"on {self.backend}"


class PathRecorder:
    """An observer of a run that records the robot's true position every `INTERVAL_S` seconds, rounded to 1 mm."""

    def __init__(self) -> None:
        self._truth: Truth | None = None
        self._points: list[tuple[float, float, float]] = []

    @property
    def path(self) -> TruePath | None:
        """The path that was recorded until now; None if the backend has no true pose."""
        return tuple(self._points) if self._truth else None

    def begin(self, run: RunContext) -> None:
        self._truth = run.truth

    def tick(self, record: TickRecord) -> None:
        if self._truth and record.time + _EARLY_S >= len(self._points) * INTERVAL_S:
            pose = self._truth.pose
            self._points.append((round(record.time, 3), round(pose.x, 3), round(pose.y, 3)))

    def end(self, result: RunResult) -> None:
        pass


def format_ending(result: RunResult) -> str:
    """Return the outcome of a run as text, followed by its reason and its dispute if it has them."""
    return ", ".join(part for part in (result.outcome_text, result.reason, result.dispute) if part)


def format_failure(record: Record) -> str:
    """Return why a run counts as failing: its outcome, its reason and its number of contacts."""
    contacts = record.result.contacts
    return format_ending(record.result) + (f", {pluralize(contacts, 'contact')}" if contacts else "")


def classify_failure(result: RunResult) -> str:
    """Return the class of a failing run: its outcome as text, or ``contact`` for a success with contacts."""
    return "contact" if result.outcome_text == Outcome.SUCCESS.value else result.outcome_text
