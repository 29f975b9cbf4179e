"""Statistics of a sweep: counts and times of groups of runs, requirements, and the agreement of two backends."""

from __future__ import annotations

import math
import re
import statistics
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TypeVar

from robotcore.errors import UsageError, suggestion
from robotcore.runtime.result import Outcome, RunResult
from robotcore.sweep.record import GroupKey, Record

Z_95 = 1.959964
"""The standard deviations around the mean within which 95 % of a normal distribution lies."""

MEASURES: dict[str, Callable[[Group], float | None]] = {
    "verified": lambda group: group.verified_share,
    "success": lambda group: group.success_share,
    "contacts": lambda group: None if group.contacts_unknown else group.contacts,
    "median_time_s": lambda group: group.median_time_s,
    "slowest_time_s": lambda group: group.slowest_time_s,
}
"""The measures of a group of runs that a requirement can bound, by name.

``verified`` and ``success`` are shares of runs from 0 to 1. ``contacts`` is the sum over all runs, and None unless
every run counted its contacts. The times are in seconds, and None if too few runs pass.
"""

_SHARES = ("verified", "success")
_TIMES = ("median_time_s", "slowest_time_s")
_FORM = re.compile(r"\s*(\w+)\s*(>=|<=)\s*(\S+)\s*")
_EXAMPLE = "Write verified>=0.97, or contacts<=0, in quotes"

Pair = tuple[RunResult, RunResult]

T = TypeVar("T")


def wilson(successes: int, n: int) -> tuple[float, float]:
    """Return the low and the high end of the 95 % Wilson score interval of a proportion. Return (0, 1) if ``n`` is 0.

    successes: the number of successes, from 0 to ``n``.
    n: the number of trials.

    Formula: E. B. Wilson, Probable inference, the law of succession, and statistical inference, Journal of the American
    Statistical Association 22 (1927), 209-212.

    >>> low, high = wilson(97, 100)
    >>> f"{low:.3f} to {high:.3f}"
    '0.915 to 0.990'
    """
    if n == 0:
        return 0.0, 1.0
    share, z2 = successes / n, Z_95**2
    centre = share + z2 / (2 * n)
    reach = Z_95 * math.sqrt(share * (1 - share) / n + z2 / (4 * n * n))
    low, high = (centre - reach) / (1 + z2 / n), (centre + reach) / (1 + z2 / n)
    return (0.0 if successes == 0 else low), (1.0 if successes == n else high)


@dataclass(frozen=True)
class Group:
    """The counts and times of the runs of one backend in one world.

    A run passes if `Record.is_failure` is false. Times are on the robot's clock. The time of a failing run counts as
    infinite, so early failures cannot make a group look fast.
    """

    backend: str
    """The name of the backend."""

    world: str
    """The name of the world; empty if the backend has no world."""

    runs: int
    """The number of runs, at least 1."""

    failing: int
    """The number of failing runs."""

    successes: int
    """The number of runs whose outcome is a success."""

    verified: int | None
    """The number of runs that the simulator or the judge verified; None if no run could be verified."""

    contacts: int | None
    """The sum of contacts over the runs that counted them; None if no run counted them."""

    contacts_unknown: int
    """The number of runs that did not count their contacts."""

    median_time_s: float | None
    """The time within which half of all runs pass, in seconds; None if fewer pass."""

    p90_time_s: float | None
    """The time within which 90 % of all runs pass, in seconds; None if fewer pass."""

    slowest_time_s: float | None
    """The time within which all runs pass, in seconds; None if a run fails."""

    @property
    def name(self) -> str:
        """The world and the backend as one text."""
        return f"{self.world} · {self.backend}" if self.world else self.backend

    @property
    def verified_share(self) -> float | None:
        """The share of verified runs, from 0 to 1; None if no run could be verified."""
        return None if self.verified is None else self.verified / self.runs

    @property
    def verified_95(self) -> tuple[float, float] | None:
        """The 95 % interval of the verified share, by `wilson`; None if no run could be verified."""
        return None if self.verified is None else wilson(self.verified, self.runs)

    @property
    def success_share(self) -> float:
        """The share of runs whose outcome is a success, from 0 to 1."""
        return self.successes / self.runs


def group_records(records: Iterable[Record]) -> list[Group]:
    """Return the group of each backend in each world, sorted by backend, then by world."""
    tallies: dict[GroupKey, Tally] = {}
    for record in records:
        tallies.setdefault(GroupKey.of(record), Tally()).add(record)
    return [tally.build_group(key) for key, tally in sorted(tallies.items())]


class Tally:
    """Adds up the runs of one backend in one world, without keeping their records in memory."""

    def __init__(self) -> None:
        self._successes = self._contacts_unknown = 0
        self._verified: int | None = None
        self._contacts: int | None = None
        self._times: list[float] = []
        """The duration of each run in seconds; infinite for a failing run."""

    def add(self, record: Record) -> None:
        """Add a run."""
        result = record.result
        self._successes += result.outcome is Outcome.SUCCESS
        self._times.append(math.inf if record.is_failure else result.sim_time_s)
        if result.verified is not None:
            self._verified = (self._verified or 0) + result.verified
        if result.contacts is None:
            self._contacts_unknown += 1
        else:
            self._contacts = (self._contacts or 0) + result.contacts

    def build_group(self, key: GroupKey) -> Group:
        """Return the group of all added runs. At least one run must have been added.

        key: the backend and the world of the runs.
        """
        times = sorted(self._times)
        return Group(
            *key,
            runs=len(times),
            failing=times.count(math.inf),
            successes=self._successes,
            verified=self._verified,
            contacts=self._contacts,
            contacts_unknown=self._contacts_unknown,
            median_time_s=_drop_infinity(_compute_median(times)),
            p90_time_s=_drop_infinity(times[math.ceil(0.9 * len(times)) - 1]),
            slowest_time_s=_drop_infinity(times[-1]),
        )


def _compute_median(times: Sequence[float]) -> float:
    """Return the median of durations. If exactly half of them are finite, return the longest finite one.

    `statistics.median` would return infinity in this case.
    """
    middle = statistics.median(times)
    return middle if math.isfinite(middle) else statistics.median_low(times)


def _drop_infinity(time: float) -> float | None:
    return time if math.isfinite(time) else None


@dataclass(frozen=True)
class Requirement:
    """A bound of a measure that every backend must meet in every world.

    >>> requirement = Requirement.parse("verified>=0.97")
    >>> requirement.measure, requirement.relation, requirement.bound
    ('verified', '>=', 0.97)
    """

    measure: str
    """The name of a measure in `MEASURES`."""

    relation: str
    """The relation between measure and bound: ``>=`` or ``<=``."""

    bound: float
    """The smallest (for ``>=``) or largest (for ``<=``) value that meets the requirement."""

    @classmethod
    def parse(cls, text: str) -> Requirement:
        """Return the requirement in a text such as ``contacts<=0``. Raises UsageError if the text has another form."""
        if not (found := _FORM.fullmatch(text)):
            raise UsageError(f"--require {text!r} is not a requirement. {_EXAMPLE}", kind="bad-requirement", text=text)
        measure, relation, number = found.groups()
        if measure not in MEASURES:
            raise UsageError(
                f"--require {text!r}: {measure!r} is not a measure. {suggestion(measure, list(MEASURES))}",
                kind="unknown-measure",
                text=text,
                measure=measure,
            )
        return cls(measure, relation, _parse_bound(text, measure, number))

    def __str__(self) -> str:
        return f"{self.measure}{self.relation}{repr(self.bound).removesuffix('.0')}"

    def evaluate(self, group: Group) -> float | None:
        """Return the value of the measure for a group of runs; None if the value is unknown."""
        return MEASURES[self.measure](group)

    def format_value(self, group: Group) -> str:
        """Return the value of the measure for a group of runs as text, ``never`` or ``unknown``."""
        value = self.evaluate(group)
        if value is None:
            return "never" if self.measure in _TIMES else "unknown"
        return f"{value:.6g}" if isinstance(value, float) else str(value)

    def is_met_by(self, group: Group) -> bool:
        """Return whether a group of runs meets the bound. An unknown value meets no bound."""
        value = self.evaluate(group)
        if value is None:
            return False
        return value >= self.bound if self.relation == ">=" else value <= self.bound


def list_missed_requirements(requirements: Sequence[Requirement], groups: Sequence[Group]) -> list[str]:
    """Return a line of text for each group and each requirement that it misses, with the group's value."""
    return [
        f"{group.backend}, {group.world}: {each.measure} is {each.format_value(group)}, required {each}"
        for each in requirements
        for group in groups
        if not each.is_met_by(group)
    ]


def list_met_requirements(requirements: Sequence[Requirement], groups: Sequence[Group]) -> list[Requirement]:
    """Return the requirements that every group meets."""
    return [each for each in requirements if all(map(each.is_met_by, groups))]


def _parse_bound(text: str, measure: str, number: str) -> float:
    try:
        bound = float(number)
    except ValueError:
        raise UsageError(
            f"--require {text!r}: {number!r} is not a number. {_EXAMPLE}", kind="bad-bound", text=text
        ) from None
    if measure in _SHARES and not 0 <= bound <= 1:
        raise UsageError(
            f"--require {text!r}: {measure} is a share from 0 to 1. Write 97 % as 0.97",
            kind="bound-out-of-range",
            text=text,
        )
    if not 0 <= bound < math.inf:
        raise UsageError(
            f"--require {text!r}: the bound must be a finite number that is not negative. {_EXAMPLE}",
            kind="bound-out-of-range",
            text=text,
        )
    return bound


@dataclass(frozen=True)
class Agreement:
    """The agreement of two backends in the runs that both executed."""

    first: str
    """The name of the first backend."""

    second: str
    """The name of the second backend."""

    pairs: tuple[Pair, ...]
    """The results of the runs that both executed: pairs of a result of the first and a result of the second backend."""

    @property
    def same_outcome(self) -> int:
        """The number of pairs whose outcomes are equal."""
        return sum(one.outcome is other.outcome for one, other in self.pairs)

    @property
    def same_milestones(self) -> int:
        """The number of pairs whose milestones are equal and in the same order."""
        return sum(list(one.milestones) == list(other.milestones) for one, other in self.pairs)

    @property
    def differing(self) -> tuple[Pair, ...]:
        """The pairs whose outcomes or milestones differ."""
        return tuple(pair for pair in self.pairs if _list_events(pair[0]) != _list_events(pair[1]))


def compare_backends(records: Sequence[Record]) -> list[Agreement]:
    """Return the agreement of each pair of backends that executed the same app, robot, world and seed."""
    runs: dict[str, dict[Hashable, RunResult]] = {}
    for record in records:
        runs.setdefault(record.result.backend, {})[_make_key(record.result)] = record.result
    found = (
        Agreement(
            first,
            second,
            tuple((runs[first][case], runs[second][case]) for case in runs[first] if case in runs[second]),
        )
        for first, second in combinations(runs, 2)
    )
    return [each for each in found if each.pairs]


def _make_key(result: RunResult) -> Hashable:
    return result.app, result.robot, result.world, result.seed


def _list_events(result: RunResult) -> tuple[object, ...]:
    return result.outcome, *result.milestones


def subsample(items: Sequence[T], most: int) -> list[T]:
    """Return at most ``most`` of the items, evenly spaced. The first item is always among them.

    >>> subsample(range(10), 3)
    [0, 3, 6]
    """
    if len(items) <= most:
        return list(items)
    return [items[index * len(items) // most] for index in range(most)]
