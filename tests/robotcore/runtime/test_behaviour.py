from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from robotcore import Behaviour, Robot, RunRequest, Status, run
from robotcore.errors import BehaviourError
from robotcore.testing import MockRobot
from tests.texts import Raises

APP = """
from robotcore import Behaviour, RunRequest, Status, run

class App(Behaviour):
    def step(self, robot):
        return Status.SUCCESS
"""


@pytest.mark.slow
def test_script_that_defines_two_apps_names_one_of_them(tmp_path: Path) -> None:
    file = tmp_path / "two.py"
    file.write_text(f"{APP}class Other(App): ...")
    ended = subprocess.run([sys.executable, str(file)], capture_output=True, text=True, check=False)
    assert ended.stderr.endswith(f"robotcore run {file}:Other\n")


@pytest.mark.slow
@pytest.mark.parametrize(
    "last_line, is_advised", [("", True), ("run(RunRequest(App))", False), ("raise ValueError('typo')", False)]
)
def test_script_that_defines_an_app_and_runs_none_says_how_to_run_it(
    tmp_path: Path, last_line: str, *, is_advised: bool
) -> None:
    file = tmp_path / "my_app.py"
    file.write_text(APP + last_line)
    ended = subprocess.run([sys.executable, str(file)], capture_output=True, text=True, check=False)
    advice = f"note: {file} defines the app App, but does not run it. Run it: robotcore run {file}\n"
    assert (ended.stderr == advice) == is_advised


class Standing(Behaviour):
    def step(self, robot: Robot) -> Status:
        return Status.SUCCESS


@pytest.mark.parametrize(
    "name, value, kind",
    [
        ("stopping", 0.3, "not-a-stopping"),
        ("stopping", (0.28, 0.2), "not-a-stopping"),
        ("stopping", lambda _: 0.3, "not-a-stopping"),
        ("stopping", property(lambda _: 1 / 0), "behaviour"),
        ("milestones", "go", "milestones-not-texts"),
        ("milestones", (1, 2), "milestones-not-texts"),
    ],
    ids=["number", "pair", "method", "error", "text", "numbers"],
)
def test_declarations_of_another_type_are_refused(name: str, value: object, kind: str, raises: Raises) -> None:
    app = type("Wrong", (Standing,), {name: value})
    with raises(BehaviourError, kind):
        run(RunRequest(app, world="open"))
    with pytest.raises(BehaviourError):
        MockRobot().run(app())
