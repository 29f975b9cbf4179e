"""The record of one run of a sweep, and its form as one line of JSON."""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple, get_type_hints

from pydantic import ConfigDict, ValidationError, create_model

from robotcore.description import first_mistake
from robotcore.runtime.result import Outcome, RunResult

if TYPE_CHECKING:
    from robotcore.hal.truth import Truth
    from robotcore.runtime.session import Run
    from robotcore.runtime.trace import TickRecord


MAX_RESULT_TEXT = 2000
"""The most characters of a reason or a note in the results. The text of an app's exception may have millions."""

MAX_NOTES = 100
"""The most notes of a run in the results of a sweep."""

TruePath = tuple[tuple[float, float, float], ...]
"""The true positions of the robot: (t, x, y) in seconds and metres, in the order of time."""

_SURROGATE = re.compile("[\ud800-\udfff]")

INTERVAL_S = 0.5
"""The seconds between two points of a path."""

_EARLY_S = 1e-6
"""The tolerance for a tick's time, in seconds. The time is a sum of steps, so rounding may make it too small."""


@dataclass(frozen=True)
class Record:
    """One run of a sweep.

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
    """The robot's true positions; None if the backend has no true pose."""

    command: str
    """The shell command that repeats the run."""

    picture: str | None = None
    """The path of the PNG of a failing run, relative to the sweep's folder; None if there is none."""

    @property
    def is_failure(self) -> bool:
        """Whether the run counts as failing.

        A run fails if its outcome is not ``success``, if the judge or the simulator contradicts it, or after a contact.
        """
        result = self.result
        return result.outcome is not Outcome.SUCCESS or result.verified is False or bool(result.contacts)

    def to_json(self) -> str:
        """Return one line of JSON with the keys of the result, then ``command``, ``path`` and ``picture``.

        JSON has no NaN and no infinity. Such a number becomes null. A point of the path with such a number is left out.
        A lone surrogate in a text is written as an escape.
        """
        payload = json.loads(self.result.to_json(), parse_constant=lambda _: None)
        path = self.path and [point for point in self.path if all(map(math.isfinite, point))]
        payload.update(command=self.command, path=path, picture=self.picture)
        line = json.dumps(payload, allow_nan=False, ensure_ascii=False)
        return _SURROGATE.sub(lambda found: rf"\\u{ord(found[0]):x}", line)

    @classmethod
    def from_json(cls, line: str | bytes) -> Record:
        """Return the record in a line that `to_json` wrote. Raises ValueError if the line is no record."""
        try:
            values = vars(_Line.model_validate_json(line.strip()))
        except ValidationError as error:
            raise ValueError(f"not a record of a run: {_format_error(error)}") from error
        return cls(
            path=values.pop("path"),
            command=values.pop("command"),
            picture=values.pop("picture"),
            result=RunResult(**values),
        )


def shorten(result: RunResult) -> RunResult:
    """Return the result with its reason and notes cut to `MAX_RESULT_TEXT` and `MAX_NOTES`.

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
"""The pydantic model of a line. It requires every field of the result and of the record."""


def _format_error(error: ValidationError) -> str:
    first = error.errors(include_url=False)[0]
    if first["type"] == "json_invalid":
        column = first["msg"].rpartition(" ")[2]
        return f"it is not JSON, from column {column} on" if int(column) else "the line is empty"
    key, mistake = first_mistake(error)
    return f"{key} {mistake}" if key else "it is not a JSON object"


class GroupKey(NamedTuple):
    """The backend and the world of a group of runs."""

    backend: str
    """The name of the backend."""

    world: str
    """The name of the world; empty if the backend has no world."""

    @classmethod
    def of(cls, record: Record) -> GroupKey:
        """Return the backend and world of a run."""
        return cls(record.result.backend, record.result.world or "")

    def __str__(self) -> str:
        return f"in {self.world} on {self.backend}" if self.world else f"on {self.backend}"


class PathRecorder:
    """An observer that records the true position every `INTERVAL_S` seconds, rounded to 1 mm."""

    def __init__(self) -> None:
        self._truth: Truth | None = None
        self._points: list[tuple[float, float, float]] = []

    @property
    def path(self) -> TruePath | None:
        """The path so far; None if the backend has no true pose."""
        return tuple(self._points) if self._truth else None

    def begin(self, run: Run) -> None:
        self._truth = run.truth

    def tick(self, record: TickRecord) -> None:
        if self._truth and record.time + _EARLY_S >= len(self._points) * INTERVAL_S:
            pose = self._truth.pose
            self._points.append((round(record.time, 3), round(pose.x, 3), round(pose.y, 3)))

    def end(self, result: RunResult) -> None:
        pass


def format_ending(result: RunResult) -> str:
    """Return the outcome of a run as text, followed by the reason and the dispute if the result has them."""
    return ", ".join(part for part in (result.outcome.value, result.reason, result.dispute) if part)


def format_failure(record: Record) -> str:
    """Return why a run counts as failing: its outcome, its reason, and the number of its contacts."""
    contacts = record.result.contacts
    touched = f", {contacts} contact{'' if contacts == 1 else 's'}" if contacts else ""
    return format_ending(record.result) + touched


def classify_failure(result: RunResult) -> str:
    """Return the class of a failing run: its outcome, ``not verified`` or ``contact``."""
    if result.outcome is not Outcome.SUCCESS:
        return str(result.outcome.value)
    return "not verified" if result.dispute else "contact"
