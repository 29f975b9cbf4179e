"""What is kept of each run of a sweep: one line of JSON."""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass, replace
from typing import Any, get_type_hints

from pydantic import ConfigDict, ValidationError, create_model

from robotcore.description import first_mistake
from robotcore.runtime.outcome import Outcome, RunResult

MAX_RESULT_TEXT = 2000
"""The most characters of a reason or a note in the results of a sweep: an exception may print a whole picture."""

MOST_NOTES = 100

TruePath = tuple[tuple[float, float, float], ...]
"""Where the robot truly was: (t, x, y) in seconds and metres, in the order of time."""


@dataclass(frozen=True)
class Record:
    """One run of a sweep.

    ``path`` is None where nobody knows the true pose; ``command`` repeats the run in a shell; ``picture`` is the PNG
    of a failing run, relative to the sweep's folder.
    """

    result: RunResult
    path: TruePath | None
    command: str
    picture: str | None = None

    @property
    def is_failure(self) -> bool:
        """Whether somebody should look at the run: no success, not verified, or something was touched."""
        result = self.result
        return result.outcome is not Outcome.SUCCESS or result.verified is False or bool(result.contacts)

    def to_json(self) -> str:
        """Return the keys of the result, then ``command``, ``path`` and ``picture``, as one line of JSON.

        JSON has no NaN and no infinity: such a number becomes null, such a point of the path is left out. What is no
        Unicode is told by its escapes.
        """
        told = json.loads(self.result.to_json(), parse_constant=lambda _: None)
        path = self.path and [point for point in self.path if all(map(math.isfinite, point))]
        told.update(command=self.command, path=path, picture=self.picture)
        line = json.dumps(told, allow_nan=False, ensure_ascii=False)
        return _SURROGATE.sub(lambda found: rf"\\u{ord(found[0]):x}", line)

    @classmethod
    def from_json(cls, line: str | bytes) -> Record:
        """Return the record that `to_json` told; ValueError, in plain words, where the line is none."""
        try:
            told = vars(_Line.model_validate_json(line.strip()))
        except ValidationError as error:
            raise ValueError(f"no record of a run: {_fault(error)}") from error
        return cls(
            path=told.pop("path"), command=told.pop("command"), picture=told.pop("picture"), result=RunResult(**told)
        )


def shorten(result: RunResult) -> RunResult:
    """Return a result whose reason and notes are so short that many results fit in a file.

    >>> short = shorten(RunResult("a", "b", "c", None, 1, Outcome.ERROR, 5, reason="x" * 2500))
    >>> short.reason[-26:]
    'xxx… (500 more characters)'
    """
    notes = [_cut(note) for note in result.notes[:MOST_NOTES]]
    if (more := len(result.notes) - MOST_NOTES) > 0:
        notes.append(f"… ({more} more notes)")
    return replace(result, reason=_cut(result.reason), notes=notes)


def _cut(text: str) -> str:
    more = len(text) - MAX_RESULT_TEXT
    return f"{text[:MAX_RESULT_TEXT]}… ({more} more characters)" if more > 0 else str(text)


_SURROGATE = re.compile("[\ud800-\udfff]")

_hints = get_type_hints(RunResult) | get_type_hints(Record)
_required: dict[str, Any] = {name: (kind, ...) for name, kind in _hints.items() if name not in ("result", "error")}
_Line = create_model("_Line", __config__=ConfigDict(strict=True, allow_inf_nan=False), **_required)
"""A line: the fields of both, but for what is no JSON, each of them there."""


def _fault(error: ValidationError) -> str:
    first = error.errors(include_url=False)[0]
    if first["type"] == "json_invalid":
        column = first["msg"].rpartition(" ")[2]
        return f"it is no JSON from column {column} on" if int(column) else "the line is empty"
    key, fault = first_mistake(error)
    return f"{key} {fault}" if key else "it is no JSON object"
