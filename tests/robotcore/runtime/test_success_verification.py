from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from robotcore import Outcome, RunRequest, run
from robotcore.errors import BehaviourError, UsageError
from robotcore.plugins import app_names
from robotcore.runtime.success_verification import load_judge
from tests.texts import CheckText, Raises

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
        self.reason = helper.NAME
        return Status.{status}

    def verify(self, truth):
        {ask_judge}
"""


@pytest.fixture
def app(tmp_path: Path) -> App:
    """Return a function that writes an app, with a module beside it, into a folder. The app ends at once."""

    def write(
        folder: str, ask_judge: str = "return True", status: str = "SUCCESS", fields: str = "speed: float = 0.1"
    ) -> str:
        file = tmp_path / folder / "robot.py"
        file.parent.mkdir(exist_ok=True)
        file.with_name("helper.py").write_text(f"NAME = {folder!r}\n")
        file.write_text(APP.format(name=folder.title(), ask_judge=ask_judge, status=status, fields=fields))
        return str(file)

    return write


def test_judge_verifies_instead_of_the_app(app: App) -> None:
    pupil = app("pupil")
    assert run(RunRequest(pupil, world="open")).verified is True
    assert run(RunRequest(pupil, world="open", judge="green-search")).verified is False
    assert run(RunRequest(app("pupil", "1 / 0"), world="open", judge=app("judge"))).verified is True


def test_app_and_judge_each_import_the_module_beside_them(app: App) -> None:
    judge = app("judge", "import helper as late; return helper.NAME == late.NAME == 'judge'")
    for _ in range(2):
        result = run(RunRequest(app("pupil"), world="open", judge=judge))
        assert (result.reason, result.verified) == ("pupil", True)


@pytest.mark.parametrize(
    "code, cause",
    [
        ("1 / 0", ZeroDivisionError),
        ("exit(3)", SystemExit),
        ("import numpy; return bool(numpy.ones(2) > 0)", ValueError),
    ],
)
def test_error_of_a_judge_names_the_judge(
    app: App, code: str, cause: type[BaseException], check_text: CheckText
) -> None:
    judge = app("judge", code)
    result = run(RunRequest(app("pupil"), world="open", judge=judge))
    assert (result.outcome, result.exit_status, result.verified) == (Outcome.ERROR, 5, None)
    assert isinstance(result.error, BehaviourError)
    assert isinstance(result.error.__cause__, cause)
    check_text(result.reason, hide=[str(result.error.__cause__)] if cause is ValueError else [])


@pytest.mark.parametrize(
    "code, kind",
    [("return 1.77", "not-a-verdict"), ("return 'no'", "not-a-verdict"), ("...\n    verify = 1", "method-hidden")],
)
def test_verdict_of_another_type_is_an_error(app: App, code: str, kind: str, check_text: CheckText) -> None:
    result = run(RunRequest(app("pupil", code), world="open"))
    assert (result.outcome, result.exit_status, result.verified) == (Outcome.ERROR, 5, None)
    assert isinstance(result.error, BehaviourError)
    assert result.error.kind == kind
    check_text(result.reason)


def test_app_without_verify_is_no_judge(raises: Raises) -> None:
    with raises(UsageError, "judge-without-verify"):
        load_judge("mark-green")


def test_setting_of_a_judge_needs_a_default(app: App, raises: Raises) -> None:
    with raises(UsageError, "judge-setting-missing", setting="bar"):
        load_judge(app("judge", fields="bar: float"))


def test_empty_name_of_a_judge_is_refused(app: App, raises: Raises) -> None:
    with raises(UsageError, "unknown-judge", hide=[", ".join(app_names())]):
        run(RunRequest(app("pupil"), world="open", judge=""))
