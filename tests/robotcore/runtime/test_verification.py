from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from robotcore import Outcome, RunRequest, run
from robotcore.errors import UsageError
from robotcore.runtime.verification import load_judge

App = Callable[..., str]

APP = """
from dataclasses import dataclass
from robotcore import Behaviour, Role, Status
import helper

@dataclass
class {name}(Behaviour):
    {fields}
    needs = frozenset({{Role.DRIVE}})

    def step(self, robot):
        import helper
        self.reason = helper.WORDS
        return Status.{status}

    def verify(self, truth):
        {ask_judge}
"""


@pytest.fixture
def app(tmp_path: Path) -> App:
    """A file of a folder's own, with a helper beside it: it ends at once, and judges as it is told."""

    def write(
        folder: str, ask_judge: str = "return True", status: str = "SUCCESS", fields: str = "speed: float = 0.1"
    ) -> str:
        file = tmp_path / folder / "robot.py"
        file.parent.mkdir(exist_ok=True)
        file.with_name("helper.py").write_text(f"WORDS = {folder!r}\n")
        file.write_text(APP.format(name=folder.title(), ask_judge=ask_judge, status=status, fields=fields))
        return str(file)

    return write


def test_the_judge_decides_and_not_the_app(app: App) -> None:
    pupil = app("pupil")
    assert run(RunRequest(pupil, world="open")).verified is True
    assert run(RunRequest(pupil, world="open", judge="green-search")).verified is False
    assert run(RunRequest(app("pupil", "1 / 0"), world="open", judge=app("judge"))).verified is True


def test_only_a_success_is_verified_whatever_the_judge_says(app: App) -> None:
    result = run(RunRequest(app("pupil", status="FAILURE"), world="open", judge=app("judge")))
    assert (result.outcome, result.verified) == (Outcome.FAILURE, False)


def test_two_files_of_one_name_each_have_the_helper_beside_them(app: App) -> None:
    judge = app("judge", "import helper as late; return helper.WORDS == late.WORDS == 'judge'")
    for _ in range(2):
        result = run(RunRequest(app("pupil"), world="open", judge=judge))
        assert (result.reason, result.verified) == ("pupil", True)


@pytest.mark.parametrize(
    "deed, said",
    [
        ("1 / 0", "ZeroDivisionError: division by zero"),
        ("exit(3)", "SystemExit: 3"),
        ("import numpy; return numpy.ones(2) > 0", "ValueError: The truth value .*"),
    ],
)
def test_a_judge_that_raises_is_named_by_its_own_name(app: App, deed: str, said: str) -> None:
    judge = app("judge", deed)
    result = run(RunRequest(app("pupil"), world="open", judge=judge))
    assert (result.outcome, result.exit_status, result.verified) == (Outcome.ERROR, 5, None)
    assert re.fullmatch(f"--judge {judge}: Judge raised {said}", result.reason)


def test_an_app_without_verify_is_no_judge() -> None:
    with pytest.raises(UsageError, match=r"--judge avoid-obstacles: it has no verify, .*such as green-search"):
        load_judge("avoid-obstacles")


def test_a_judge_is_taken_with_its_defaults(app: App) -> None:
    with pytest.raises(UsageError, match=r"--judge .*robot\.py: its setting bar has no default. Give it one"):
        load_judge(app("judge", fields="bar: float"))


def test_a_judge_without_a_name_is_not_the_app_itself(app: App) -> None:
    with pytest.raises(UsageError, match="--judge: unknown app ''"):
        run(RunRequest(app("pupil"), world="open", judge=""))


def test_a_judge_that_counts_as_nothing_judges_all_the_same(app: App) -> None:
    judge = app("judge", "return False\n    def __len__(self):\n        return 0")
    assert run(RunRequest(app("pupil"), world="open", judge=judge)).verified is False


def test_a_judge_that_is_not_there_is_refused_before_the_app_is_loaded(app: App) -> None:
    with pytest.raises(UsageError, match=r"--judge: .*Did you mean 'green-search'"):
        run(RunRequest(app("pupil"), judge="green-serch"))
