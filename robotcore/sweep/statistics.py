"""Statistics of a sweep: counts and times of groups of runs, requirements, and the agreement of two backends."""

from __future__ import annotations

import math
import re
import statistics
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TypeVar

from robotcore.errors import UsageError
from robotcore.runtime.result import Outcome, RunResult
from robotcore.sweep.record import GroupKey, Record
from robotcore.text import suggestion

__all__ = ["Agreement", "Group", "Requirement", "compare_backends", "group_records", "wilson"]

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
_FORM = re.compile(r"\s*(?P<measure>\w+)\s*(?P<relation>>=|<=)\s*(?P<bound>\d{1,18}(\.\d*)?)\s*")
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

    >>> from robotcore import Outcome, RunResult
    >>> from robotcore.sweep import Record
    >>> from robotcore.sweep.statistics import group_records
    >>> results = [RunResult("search", "kinematic", "rover", "arena", seed, Outcome.SUCCESS, 0) for seed in (1, 2)]
    >>> (group,) = group_records([Record(result, None, "") for result in results])
    >>> group.name, group.runs, group.success_share, group.verified_share
    ('arena · kinematic', 2, 1.0, None)
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
    """Return the group of each backend in each world, sorted by backend, then by world.

    Keeps only four numbers of each record in memory.

    records: the records of the runs, such as ``results.records()``.

    >>> from robotcore import Outcome, RunResult
    >>> from robotcore.sweep import Record
    >>> outcomes = {1: Outcome.SUCCESS, 2: Outcome.TIMEOUT}
    >>> results = [RunResult("search", "kinematic", "rover", "arena", *each, 0) for each in outcomes.items()]
    >>> [group.success_share for group in group_records([Record(result, None, "") for result in results])]
    [0.5]
    """
    runs: dict[GroupKey, list[tuple[float, bool, bool | None, int | None]]] = {}
    for record in records:
        result = record.result
        time = math.inf if record.is_failure else result.sim_time_s
        row = (time, result.outcome is Outcome.SUCCESS, result.verified, result.contacts)
        runs.setdefault(GroupKey.from_record(record), []).append(row)
    return [_build_group(key, *zip(*rows, strict=True)) for key, rows in sorted(runs.items())]


def _build_group(
    key: GroupKey,
    durations: Sequence[float],
    successes: Sequence[bool],
    verified: Sequence[bool | None],
    contacts: Sequence[int | None],
) -> Group:
    times = sorted(durations)
    middle = statistics.median(times)
    if math.isinf(middle):  # exactly half of the times may be finite
        middle = statistics.median_low(times)
    p90 = times[math.ceil(0.9 * len(times)) - 1]
    median_s, p90_s, slowest_s = (time if math.isfinite(time) else None for time in (middle, p90, times[-1]))
    return Group(
        *key,
        runs=len(times),
        failing=times.count(math.inf),
        successes=sum(successes),
        verified=_sum_known(verified),
        contacts=_sum_known(contacts),
        contacts_unknown=contacts.count(None),
        median_time_s=median_s,
        p90_time_s=p90_s,
        slowest_time_s=slowest_s,
    )


def _sum_known(values: Iterable[int | None]) -> int | None:
    known = [value for value in values if value is not None]
    return sum(known) if known else None


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
        """Return the requirement in a text such as ``contacts<=0``. Raises UsageError for any other text."""
        found = _FORM.fullmatch(text)
        if not found:
            problem = f"it is not a requirement. {_EXAMPLE}"
        elif found["measure"] not in MEASURES:
            measure = found["measure"]
            problem = f"{measure!r} is not a measure. {suggestion(measure, list(MEASURES))}"
        elif found["measure"] in _SHARES and float(found["bound"]) > 1:
            problem = f"{found['measure']} is a share from 0 to 1. Write 97 % as 0.97"
        else:
            return cls(found["measure"], found["relation"], float(found["bound"]))
        raise UsageError(f"--require {text!r}: {problem}", kind="bad-requirement", text=text)

    def __str__(self) -> str:
        return f"{self.measure}{self.relation}{repr(self.bound).removesuffix('.0')}"

    def format_value(self, group: Group) -> str:
        """Return the value of the measure for a group of runs as text, ``never`` or ``unknown``."""
        value = MEASURES[self.measure](group)
        if value is None:
            return "never" if self.measure.endswith("_time_s") else "unknown"
        return f"{value:.6g}" if isinstance(value, float) else str(value)

    def is_met_by(self, group: Group) -> bool:
        """Return whether a group of runs meets the bound. An unknown value meets no bound."""
        value = MEASURES[self.measure](group)
        if value is None:
            return False
        return value >= self.bound if self.relation == ">=" else value <= self.bound


def list_missed_requirements(requirements: Sequence[Requirement], groups: Sequence[Group]) -> list[str]:
    """Return a line of text for each group and each requirement that it misses, with the group's value."""
    return [format_miss(each, group) for each in requirements for group in groups if not each.is_met_by(group)]


def format_miss(requirement: Requirement, group: Group) -> str:
    """Return a line of text for a group that misses a requirement, with the group's value."""
    value = requirement.format_value(group)
    return f"{group.backend}, {group.world}: {requirement.measure} is {value}, required {requirement}"


@dataclass(frozen=True)
class Agreement:
    """The agreement of two backends in the runs that both executed.

    >>> from robotcore import Outcome, RunResult
    >>> one = RunResult("search", "kinematic", "rover", "arena", 7, Outcome.SUCCESS, 0)
    >>> other = RunResult("search", "mujoco", "rover", "arena", 7, Outcome.TIMEOUT, 1)
    >>> Agreement("kinematic", "mujoco", ((one, one), (one, other))).same_outcome
    1
    """

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
        return tuple(
            (one, other)
            for one, other in self.pairs
            if one.outcome is not other.outcome or list(one.milestones) != list(other.milestones)
        )


def compare_backends(records: Sequence[Record]) -> list[Agreement]:
    """Return the agreement of each pair of backends that executed the same app, robot, world and seed.

    records: the records of the runs, such as ``results.records()``.

    >>> from robotcore import Outcome, RunResult
    >>> from robotcore.sweep import Record
    >>> backends = ("kinematic", "mujoco")
    >>> results = [RunResult("search", name, "rover", "arena", 7, Outcome.SUCCESS, 0) for name in backends]
    >>> (agreement,) = compare_backends([Record(result, None, "") for result in results])
    >>> agreement.first, agreement.second, agreement.same_outcome
    ('kinematic', 'mujoco', 1)
    """
    runs: dict[str, dict[Hashable, RunResult]] = {}
    for result in (record.result for record in records):
        runs.setdefault(result.backend, {})[result.app, result.robot, result.world, result.seed] = result
    found = (
        Agreement(first, second, tuple((result, ours[case]) for case, result in theirs.items() if case in ours))
        for (first, theirs), (second, ours) in combinations(runs.items(), 2)
    )
    return [each for each in found if each.pairs]


def subsample(items: Sequence[T], most: int) -> list[T]:
    """Return at most ``most`` of the items, evenly spaced. The first item is always among them.

    >>> subsample(range(10), 3)
    [0, 3, 6]
    """
    if len(items) <= most:
        return list(items)
    return [items[index * len(items) // most] for index in range(most)]
