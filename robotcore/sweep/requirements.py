"""What a sweep must reach, as one writes it: ``verified>=0.97``, ``contacts<=0``."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from robotcore.errors import UsageError, suggestion
from robotcore.sweep.statistics import Group

MEASURES: dict[str, Callable[[Group], float | None]] = {
    "verified": lambda group: group.verified_share,
    "success": lambda group: group.success_share,
    "contacts": lambda group: None if group.untold else group.contacts,
    "median_time_s": lambda group: group.median_time_s,
    "slowest_time_s": lambda group: group.slowest_time_s,
}
"""What can be required of each backend in each world; the first two are shares from 0 to 1, the third a total.

Contacts are known only where every run told of them: one that hangs may have touched anything.
"""

_SHARES = ("verified", "success")
_TIMES = ("median_time_s", "slowest_time_s")
_FORM = re.compile(r"\s*(\w+)\s*(>=|<=)\s*(\S+)\s*")
_EXAMPLE = "Write verified>=0.97, or contacts<=0, in quotes"


@dataclass(frozen=True)
class Requirement:
    """A bound that every backend must keep in every world."""

    measure: str
    relation: str
    bound: float

    @classmethod
    def parse(cls, text: str) -> Requirement:
        """Return what is written; UsageError says what would be right."""
        if not (found := _FORM.fullmatch(text)):
            raise UsageError(f"--require {text!r} is no requirement. {_EXAMPLE}")
        measure, relation, number = found.groups()
        if measure not in MEASURES:
            raise UsageError(f"--require {text!r}: unknown measure. {suggestion(measure, list(MEASURES))}")
        return cls(measure, relation, _bound(text, measure, number))

    def __str__(self) -> str:
        return f"{self.measure}{self.relation}{repr(self.bound).removesuffix('.0')}"

    def got(self, group: Group) -> float | None:
        """Return what a group reached; None where nobody knows, or too few runs pass for such a time."""
        return MEASURES[self.measure](group)

    def told(self, group: Group) -> str:
        """Return what a group reached in words."""
        got = self.got(group)
        if got is None:
            return "never" if self.measure in _TIMES else "unknown"
        return f"{got:.6g}" if isinstance(got, float) else str(got)

    def is_kept_by(self, group: Group) -> bool:
        """Return whether a group keeps the bound; what is None keeps none."""
        got = self.got(group)
        if got is None:
            return False
        return got >= self.bound if self.relation == ">=" else got <= self.bound


def missed(requirements: Sequence[Requirement], groups: Sequence[Group]) -> list[str]:
    """Return a line for each group that does not keep a requirement: what it got, and what was required."""
    return [
        f"{group.backend}, {group.world}: {each.measure} is {each.told(group)}, required {each}"
        for each in requirements
        for group in groups
        if not each.is_kept_by(group)
    ]


def kept(requirements: Sequence[Requirement], groups: Sequence[Group]) -> list[Requirement]:
    """Return the requirements that every group keeps."""
    return [each for each in requirements if all(map(each.is_kept_by, groups))]


def _bound(text: str, measure: str, number: str) -> float:
    try:
        bound = float(number)
    except ValueError:
        raise UsageError(f"--require {text!r}: {number!r} is no number. {_EXAMPLE}") from None
    if measure in _SHARES and not 0 <= bound <= 1:
        raise UsageError(f"--require {text!r}: {measure} is a share from 0 to 1; write 97 % as 0.97")
    if not 0 <= bound < math.inf:
        raise UsageError(f"--require {text!r}: the bound must be a number from 0 on")
    return bound
