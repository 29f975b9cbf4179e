"""Projects and packages that ``robotcore new`` of each released version made run, and pass their tests."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.compatibility.conftest import HERE, VERSIONS
from tests.robotcore.cli.scaffold.test_first_commands import TESTS, install, type_command

pytestmark = [pytest.mark.slow, pytest.mark.parametrize("version", VERSIONS)]


def copy(version: str, name: str, tmp_path: Path) -> Path:
    folder = tmp_path / name
    shutil.copytree(HERE / version / name, folder)
    return folder


def test_a_project_passes_its_tests_and_runs(version: str, tmp_path: Path) -> None:
    folder = copy(version, "old-robot", tmp_path)
    tested = type_command(folder, *TESTS)
    assert tested.returncode == 0, tested.stdout
    command = "robotcore run search.py --robot old_robot.toml --world room.toml --seed 7"
    ran = type_command(folder, *command.split())
    assert ran.returncode == 0, ran.stderr


def test_a_driver_package_passes_the_conformance_kit_and_runs_an_app(version: str, tmp_path: Path) -> None:
    folder = copy(version, "old-board", tmp_path)
    path = install(folder)
    tested = type_command(folder, *TESTS, path=path)
    assert tested.returncode == 0, tested.stdout
    command = "robotcore run avoid-obstacles --backend old-board --robot old_board.toml --set duration_s=2"
    ran = type_command(folder, *command.split(), path=path)
    assert ran.returncode == 0, ran.stderr


def test_a_package_with_a_kind_passes_its_tests_and_its_app_runs(version: str, tmp_path: Path) -> None:
    folder = copy(version, "old-sensor", tmp_path)
    path = install(folder)
    tested = type_command(folder, *TESTS, path=path)
    assert tested.returncode == 0, tested.stdout
    command = "robotcore run cautious.py --robot robot.toml --world open"
    ran = type_command(folder, *command.split(), path=path)
    assert ran.returncode == 0, ran.stderr
