from __future__ import annotations

import pytest

from robotcore import Outcome, RunResult


def make_result(outcome: Outcome, *, verified: bool | None = None, contacts: int | None = None) -> RunResult:
    return RunResult("app", "kinematic", "rover", "arena", 7, outcome, 0, verified=verified, contacts=contacts)


@pytest.mark.parametrize(
    "outcome, verified, outcome_text",
    [
        (Outcome.SUCCESS, True, "success"),
        (Outcome.SUCCESS, None, "success"),
        (Outcome.SUCCESS, False, "disputed"),
        (Outcome.FAILURE, False, "failure"),
        (Outcome.TIMEOUT, False, "timeout"),
    ],
)
def test_only_a_success_without_agreement_is_disputed(
    outcome: Outcome, verified: bool | None, outcome_text: str
) -> None:
    assert make_result(outcome, verified=verified).outcome_text == outcome_text


@pytest.mark.parametrize(
    "contacts, headline",
    [(None, "success"), (0, "success"), (1, "success, 1 contact"), (2, "success, 2 contacts")],
)
def test_headline_has_the_contacts_if_there_are_any(contacts: int | None, headline: str) -> None:
    assert make_result(Outcome.SUCCESS, contacts=contacts).headline == headline


def test_repr_begins_with_the_headline() -> None:
    result = make_result(Outcome.SUCCESS, verified=False, contacts=2)
    assert repr(result) == "RunResult(app on kinematic: disputed, 2 contacts, 0 ticks, 0.0 s)"
