from __future__ import annotations

import pytest

from robotcore import Outcome, RunResult


@pytest.mark.parametrize(
    "outcome, verified, contacts, headline",
    [
        (Outcome.SUCCESS, True, 0, "success"),
        (Outcome.SUCCESS, None, 1, "success, 1 contact"),
        (Outcome.SUCCESS, False, 2, "disputed, 2 contacts"),
        (Outcome.FAILURE, False, None, "failure"),
        (Outcome.TIMEOUT, False, None, "timeout"),
    ],
)
def test_headline_has_the_contacts_and_a_success_without_agreement_is_disputed(
    outcome: Outcome, verified: bool | None, contacts: int | None, headline: str
) -> None:
    result = RunResult("app", "kinematic", "rover", "arena", 7, outcome, 0, verified=verified, contacts=contacts)
    assert repr(result) == f"RunResult(app on kinematic: {headline}, 0 ticks, 0.0 s)"
