"""Bounds on the differences of a recorded run and its simulation, for the exit status of the command line."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from robotcore.errors import UsageError
from robotcore.text import suggestion

_FORM = re.compile(r"\s*(?P<measure>[\w.-]+)\s*<=\s*(?P<bound>[0-9.eE+-]+)\s*")


@dataclass(frozen=True)
class Bound:
    """The greatest allowed value of a measure.

    >>> bound = Bound.parse("path.end_m<=0.2")
    >>> bound.find_problem({"path.end_m": 0.3})
    'path.end_m is 0.3, required path.end_m<=0.2'
    """

    measure: str
    """The dotted JSON key of the measure, such as ``path.end_m``."""
    limit: float

    @classmethod
    def parse(cls, text: str) -> Bound:
        """Return the bound in a text such as ``path.end_m<=0.2``. Raises UsageError for any other text."""
        try:
            found = _FORM.fullmatch(text)
            limit = float(found["bound"]) if found else math.nan
        except ValueError:
            limit = math.nan
        if found is None or math.isnan(limit):
            raise UsageError(
                f"--require {text!r}: it is not a bound. Write a measure, <= and a number: path.end_m<=0.2",
                kind="bad-requirement",
                text=text,
            )
        return cls(found["measure"], limit)

    def __str__(self) -> str:
        return f"{self.measure}<={self.limit:g}"

    def find_problem(self, measures: Mapping[str, float]) -> str:
        """Return a sentence about a measure above the bound, or an unknown one; ``""`` if it is within the bound.

        measures: the measures by their dotted keys; NaN for an unknown one.

        Raises UsageError if the measure is not known. The sign of a measure has no effect.
        """
        if self.measure not in measures:
            hint = suggestion(self.measure, list(measures))
            text = f"--require {self}: this comparison has no measure {self.measure!r}. {hint}"
            raise UsageError(text, kind="unknown-measure", name=self.measure, measures=list(measures))
        value = abs(measures[self.measure])
        if math.isnan(value):
            return f"{self.measure} is unknown, because the path is not known up to its end, required {self}"
        return "" if value <= self.limit else f"{self.measure} is {value:.4g}, required {self}"


def list_missed_bounds(bounds: Sequence[Bound], measures: Mapping[str, float]) -> list[str]:
    """Return a sentence for each measure that is above its bound."""
    return [problem for bound in bounds if (problem := bound.find_problem(measures))]
