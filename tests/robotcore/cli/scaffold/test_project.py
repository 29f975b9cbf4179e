"""A new project works without a change: these tests type its first commands."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import pytest

from robotcore import RunRequest, run
from robotcore.cli.main import execute
from robotcore.deploy.project import DeployOptions, DeployTable, build_project
from tests.robotcore.cli.scaffold.conftest import TypeCommand
from tests.texts import CheckText

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

TESTS = ("pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A new project in a folder with a space."""
    folder = tmp_path / "all my robots" / "scout"
    folder.parent.mkdir()
    assert execute(["new", str(folder)]) == 0
    return folder


def read_tool_table(project: Path) -> dict[str, Any]:
    """Return the table ``tool.robotcore`` of the project's pyproject.toml."""
    answer: dict[str, Any] = tomllib.loads((project / "pyproject.toml").read_text())["tool"]["robotcore"]
    return answer


def test_prints_the_first_commands(tmp_path: Path, capfd: pytest.CaptureFixture[str], check_text: CheckText) -> None:
    folder = tmp_path / "all my robots"
    folder.mkdir()
    assert execute(["new", str(folder / "scout")]) == 0
    check_text(capfd.readouterr().out)


@pytest.mark.slow
def test_passes_its_own_tests(project: Path, type_command: TypeCommand) -> None:
    assert "6 passed" in type_command(project, *TESTS).stdout


@pytest.mark.slow
def test_its_tests_fail_if_the_app_is_wrong(project: Path, type_command: TypeCommand) -> None:
    app = project / "search.py"
    app.write_text(app.read_text().replace("< self.stop_distance_m", "< 2 * self.stop_distance_m"))
    assert "4 failed, 2 passed" in type_command(project, *TESTS).stdout


def test_is_a_project_that_can_be_deployed(project: Path) -> None:
    found = build_project(DeployOptions(), here=project)
    assert found.files == ("search.py", "scout.toml", "room.toml")
    assert (found.name, found.load_description().name, found.is_package) == ("scout", "scout", False)


def test_the_commented_settings_of_deploy_are_valid(project: Path) -> None:
    file = project / "pyproject.toml"
    file.write_text(re.sub(r"^# (?=\w+ = )", "", file.read_text(), flags=re.MULTILINE))
    deploy = read_tool_table(project)["deploy"]
    assert deploy.keys() == DeployTable.model_fields.keys()
    assert build_project(DeployOptions(), here=project).settings == {"speed_m_s": "0.15"}


def test_its_robot_and_its_room_are_valid(
    project: Path, capfd: pytest.CaptureFixture[str], check_text: CheckText
) -> None:
    capfd.readouterr()
    assert execute(["check", str(project / "scout.toml")]) == 0
    assert execute(["check", str(project / "room.toml")]) == 0
    assert execute(["wiring", str(project / "scout.toml")]) == 0
    answer = capfd.readouterr().out
    check_text("\n".join(line for line in answer.splitlines() if "[raspberrypi]" in line))


@pytest.mark.parametrize("backend", ["kinematic", "virtualpi"])
def test_its_app_finds_the_ball_in_simulation_and_with_the_robots_drivers(project: Path, backend: str) -> None:
    answer: dict[str, Any] = {
        key: str(project / name) for key, name in read_tool_table(project).items() if key != "deploy"
    }
    assert run(RunRequest(**answer, backend=backend, seed=7)).verified
