from __future__ import annotations

from robotcore import Outcome
from robotcore.sweep.statistics import Group, grouped
from robotcore.sweep.words import COLUMNS, fault
from tests.robotcore.sweep.conftest import record_of

HUNG = record_of(Outcome.ERROR, verified=None, contacts=None, seed=9, time=0.0)


def told(*names: str, group: Group) -> list[str]:
    return [COLUMNS[name](group) for name in names]


def test_a_group_is_told_by_its_share_its_interval_and_its_times() -> None:
    (group,) = grouped([*(record_of(seed=seed, time=float(seed)) for seed in range(1, 20)), record_of(contacts=2)])
    assert told("backend", "world", "passed", group=group) == ["kinematic", "open", "19/20"]
    assert told("verified", "%", "95 %", "contacts", group=group) == ["20/20", "100.0", "83.9–100.0", "2"]
    assert told("median", "90 % within", "slowest", group=group) == ["10.5 s", "18.0 s", "never"]


def test_what_nobody_could_judge_has_a_question_mark_and_no_share() -> None:
    (group,) = grouped([record_of(verified=None, contacts=None)] * 3)
    assert told("passed", "verified", "%", "95 %", "contacts", group=group) == ["3/3", "?/3", "", "", "?"]


def test_contacts_that_some_runs_did_not_tell_are_at_least_those_that_were_counted() -> None:
    (group,) = grouped([record_of(contacts=2), HUNG])
    assert told("contacts", group=group) == ["≥ 2"]


def test_a_fault_says_outcome_reason_and_touches() -> None:
    assert fault(record_of(Outcome.ERROR, reason="the wheel fell off")) == "error, the wheel fell off"
    assert fault(record_of(verified=False)) == "success, the simulator does not agree"
    assert fault(record_of(verified=False, reason="there")) == "success, there, the simulator does not agree"
    assert fault(record_of(verified=False, judge="green-search")) == "success, the judge does not agree"
    assert fault(record_of(contacts=1)) == "success, 1 contact"
    assert fault(record_of(Outcome.TIMEOUT, reason="late", contacts=2)) == "timeout, late, 2 contacts"
