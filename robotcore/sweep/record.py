"""What is kept of each run of a sweep: one line of JSON."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, fields
from typing import Any

from robotcore.outcome import Outcome, RunResult

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

        JSON has no NaN and no infinity: such a number becomes null, such a point of the path is left out.
        """
        told = json.loads(self.result.to_json(), parse_constant=lambda _: None)
        path = self.path and [point for point in self.path if all(map(math.isfinite, point))]
        told.update(command=self.command, path=path, picture=self.picture)
        return json.dumps(told, allow_nan=False)

    @classmethod
    def from_json(cls, line: str | bytes) -> Record:
        """Return the record that `to_json` told; ValueError where the line, of bytes in UTF-8, is none."""
        try:
            told = json.loads(line)
            return cls(_result(told), _path(told["path"]), told["command"], told["picture"])
        except json.JSONDecodeError as error:
            raise ValueError(f"no record of a run: {error.msg} in column {error.colno}") from error
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"no record of a run: {error!r}") from error


def _path(points: list[list[float]] | None) -> TruePath | None:
    return None if points is None else tuple((t, x, y) for t, x, y in points)


def _result(told: dict[str, Any]) -> RunResult:
    known = {each.name: told[each.name] for each in fields(RunResult) if each.name in told}
    return RunResult(**{**known, "outcome": Outcome(known["outcome"])})
