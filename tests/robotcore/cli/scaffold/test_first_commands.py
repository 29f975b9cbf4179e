"""A new project and a new driver package work without a change: these tests type their first commands."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from robotcore import RunRequest, run
from robotcore.cli.main import execute
from robotcore.deploy.project import DeployOptions, DeployTable, build_project
from tests.texts import CheckText

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

HOME = Path(__file__).parents[4]
"""The folder that has the packages robotcore, drivers and apps."""

TESTS = ("pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist")


def type_command(folder: Path, *command: str, path: str = "") -> subprocess.CompletedProcess[str]:
    """Run ``python -m COMMAND`` in a folder, with robotcore installed."""
    found = os.pathsep.join(filter(None, (str(HOME), path)))
    environment = {**os.environ, "PYTHONPATH": found, "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        [sys.executable, "-m", *command],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


def make_folder(tmp_path: Path, name: str, *options: str) -> Path:
    """Create a project or a driver package in a folder with a space."""
    folder = tmp_path / "all my robots" / name
    folder.parent.mkdir()
    assert execute(["new", *options, str(folder)]) == 0
    return folder


@pytest.fixture
def project(tmp_path: Path) -> Path:
    return make_folder(tmp_path, "scout")


@pytest.fixture
def package(tmp_path: Path) -> Path:
    return make_folder(tmp_path, "tiny-board", "--driver")


def read_tool_table(project: Path) -> dict[str, Any]:
    """Return the table ``tool.robotcore`` of the project's pyproject.toml."""
    answer: dict[str, Any] = tomllib.loads((project / "pyproject.toml").read_text())["tool"]["robotcore"]
    return answer


def test_prints_the_first_commands(capfd: pytest.CaptureFixture[str], project: Path, check_text: CheckText) -> None:
    check_text(capfd.readouterr().out)


@pytest.mark.slow
def test_passes_its_own_tests(project: Path) -> None:
    assert "6 passed" in type_command(project, *TESTS).stdout


@pytest.mark.slow
def test_its_tests_fail_if_the_app_is_wrong(project: Path) -> None:
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
    assert build_project(DeployOptions(), here=project).deploy.settings == {"speed_m_s": "0.15"}


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


def install(package: Path) -> str:
    """Write the metadata of an installed package, so that its entry points are found. Return its folder."""
    project = tomllib.loads((package / "pyproject.toml").read_text())["project"]
    lines = [
        f"[{group}]\n" + "".join(f"{key} = {value}\n" for key, value in named.items())
        for group, named in project["entry-points"].items()
    ]
    name, version = project["name"], project["version"]
    about = package / f"{name.replace('-', '_')}-{version}.dist-info"
    about.mkdir()
    needs = "".join(f"Requires-Dist: {each}\n" for each in project["dependencies"])
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n{needs}")
    (about / "entry_points.txt").write_text("".join(lines))
    return str(package)


@pytest.mark.slow
def test_passes_the_conformance_kit_and_runs_an_app(package: Path) -> None:
    answer = type_command(package, *TESTS, path=install(package)).stdout
    assert "62 passed" in answer
    assert "failed" not in answer


@pytest.mark.slow
def test_its_tests_report_reversed_motors_and_encoders_and_a_missing_installation(package: Path) -> None:
    devices = package / "tiny_board" / "devices.py"
    code = devices.read_text().replace("turn(wheel, rad_s)", "turn(wheel, -rad_s)")
    devices.write_text(code.replace("Angle(self._board.angle(self._wheel)", "Angle(-self._board.angle(self._wheel)"))
    answer = type_command(package, *TESTS).stdout
    assert "encoders_count_forward_as_positive" not in answer
    assert "Negate the velocity of each motor that turns backward" in answer
    assert "install it first: pip install -e ." in answer


@pytest.mark.slow
def test_its_backend_is_found_and_runs_with_the_shipped_robot(package: Path) -> None:
    ran = type_command(package, "robotcore", "run", "avoid-obstacles", "--backend", "tiny-board", path=install(package))
    assert ran.returncode == 0, ran.stderr
    assert "success  avoid-obstacles on tiny-board" in ran.stdout
