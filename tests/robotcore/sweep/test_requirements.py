from __future__ import annotations

from dataclasses import replace

import pytest

from robotcore import Outcome
from robotcore.errors import UsageError
from robotcore.sweep.requirements import Requirement, missed
from robotcore.sweep.statistics import Group, grouped
from tests.robotcore.sweep.conftest import record_of

GOOD = Group("kinematic", "arena", 100, 3, 99, 97, 0, 0, 30.0, 60.0, 90.0)
BAD = Group("kinematic", "open", 100, 4, 90, 96, 1, 0, 31.0, 61.0, 91.0)
DARK = Group("kinematic", "lab", 100, 0, 100, None, None, 100, 3.0, 6.0, 9.0)


@pytest.mark.parametrize(
    "text", ["verified>=0.97", "success >= 0.95", "contacts<=0", "median_time_s<=30.5", "slowest_time_s<=90"]
)
def test_a_bound_is_kept_at_it_and_missed_beyond(text: str) -> None:
    requirement = Requirement.parse(text)
    assert requirement.is_kept_by(GOOD)
    assert not requirement.is_kept_by(BAD)


def test_what_nobody_knows_keeps_no_bound() -> None:
    assert missed([Requirement.parse("verified>=0"), Requirement.parse("contacts<=9")], [DARK]) == [
        "kinematic, lab: verified is unknown, required verified>=0",
        "kinematic, lab: contacts is unknown, required contacts<=9",
    ]


def test_a_miss_by_little_can_be_seen() -> None:
    group = replace(GOOD, runs=100_000, verified=99_996, contacts=12_345)
    requirements = [Requirement.parse("verified>=0.99997"), Requirement.parse("contacts<=12344")]
    assert missed(requirements, [group]) == [
        "kinematic, arena: verified is 0.99996, required verified>=0.99997",
        "kinematic, arena: contacts is 12345, required contacts<=12344",
    ]


@pytest.mark.parametrize(
    "text, got",
    [("contacts<=0", "unknown"), ("median_time_s<=120", "never"), ("slowest_time_s<=120", "never")],
)
def test_runs_that_hung_open_no_gate(text: str, got: str) -> None:
    hung = record_of(Outcome.ERROR, verified=None, contacts=None, time=0.0)
    requirement = Requirement.parse(text)
    assert missed([requirement], grouped([record_of(), hung, hung])) == [
        f"kinematic, open: {requirement.measure} is {got}, required {text}"
    ]


def test_each_group_that_misses_has_its_line() -> None:
    assert missed([Requirement.parse("verified>=0.97")], [GOOD, BAD]) == [
        "kinematic, open: verified is 0.96, required verified>=0.97"
    ]


@pytest.mark.parametrize(
    "text, fault",
    [
        ("verified", "Write verified>=0.97"),
        ("verified>0.9", "Write verified>=0.97"),
        ("verified==1", "Write verified>=0.97"),
        ("verrified>=0.9", "Did you mean 'verified'"),
        ("verified>=97", "write 97 % as 0.97"),
        ("verified>=97%", "'97%' is no number"),
        ("verified>=nan", "from 0 to 1"),
        ("contacts<=-1", "a number from 0 on"),
        ("contacts<=nan", "a number from 0 on"),
        ("median_time_s<=inf", "a number from 0 on"),
        ("slowest_time_s<=1e999", "a number from 0 on"),
    ],
)
def test_a_wrong_expression_is_answered_with_the_right_form(text: str, fault: str) -> None:
    with pytest.raises(UsageError, match=fault):
        Requirement.parse(text)
