"""What a group and a run came to, in words: the terminal and the report say the same."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from robotcore.runtime.outcome import Outcome, RunResult
from robotcore.sweep.record import Record
from robotcore.sweep.statistics import Group


def verified_told(group: Group) -> str:
    """Return how many runs the simulator verified; ``?`` where nobody can judge."""
    return f"{'?' if group.verified is None else group.verified}/{group.runs}"


def share_told(group: Group) -> str:
    """Return the share of verified runs in percent; empty where nobody can judge."""
    return "" if group.verified_share is None else f"{100 * group.verified_share:.1f}"


def interval_told(group: Group) -> str:
    """Return the 95 % interval of that share in percent."""
    return "" if group.verified_95 is None else "–".join(f"{100 * edge:.1f}" for edge in group.verified_95)


def contacts_told(group: Group) -> str:
    """Return the contacts that were counted; ``≥`` says that some runs did not tell."""
    if group.contacts is None:
        return "?"
    return f"≥ {group.contacts}" if group.untold else f"{group.contacts}"


def time_told(time_s: float | None) -> str:
    """Return a group's time, or that not so many of its runs ever pass."""
    return "never" if time_s is None else f"{time_s:.1f} s"


COLUMNS: dict[str, Callable[[Group], str]] = {
    "backend": lambda group: group.backend,
    "world": lambda group: group.world,
    "passed": lambda group: f"{group.runs - group.failing}/{group.runs}",
    "verified": verified_told,
    "%": share_told,
    "95 %": interval_told,
    "contacts": contacts_told,
    "median": lambda group: time_told(group.median_time_s),
    "90 % within": lambda group: time_told(group.p90_time_s),
    "slowest": lambda group: time_told(group.slowest_time_s),
}
"""What is told of a group; ``%`` and ``95 %`` are of the verified runs."""


def judge_told(judge: str | None, groups: Iterable[Group]) -> str:
    """Return whose word ``verified`` is: that of the app that was named for it, or the app's own, or nobody's."""
    if judge:
        return judge
    return "nobody" if all(group.verified is None for group in groups) else "the app itself"


def ending(result: RunResult) -> str:
    """Return how a run ended, and why."""
    return ", ".join(part for part in (result.outcome.value, result.reason, result.dispute) if part)


def fault(record: Record) -> str:
    """Return why a run is failing: how it ended, and what it touched."""
    contacts = record.result.contacts
    touched = f", {contacts} contact{'' if contacts == 1 else 's'}" if contacts else ""
    return ending(record.result) + touched


def kind(result: RunResult) -> str:
    """Return in a word or two what a failing run is counted as."""
    if result.outcome is not Outcome.SUCCESS:
        return str(result.outcome.value)
    return "not verified" if result.dispute else "contact"
