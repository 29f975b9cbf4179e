"""A new driver package passes its tests and runs an app, on an invented board."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from robotcore.cli.main import execute
from tests.robotcore.cli.scaffold.conftest import TypeCommand

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

TESTS = ("pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist")


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A new driver package in a folder with a space."""
    folder = tmp_path / "all my boards" / "tiny-board"
    folder.parent.mkdir()
    assert execute(["new", "--driver", str(folder)]) == 0
    return folder


def install(package: Path) -> str:
    """Write the metadata of an installed package, so that its entry points are found. Return its folder."""
    points = tomllib.loads((package / "pyproject.toml").read_text())["project"]["entry-points"]
    lines = [
        f"[{group}]\n" + "".join(f"{key} = {value}\n" for key, value in named.items())
        for group, named in points.items()
    ]
    about = package / "tiny_board-0.1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: tiny-board\nVersion: 0.1\n")
    (about / "entry_points.txt").write_text("".join(lines))
    return str(package)


@pytest.mark.slow
def test_passes_the_conformance_kit_and_runs_an_app(package: Path, type_command: TypeCommand) -> None:
    answer = type_command(package, *TESTS, path=install(package)).stdout
    assert "52 passed" in answer
    assert "failed" not in answer


@pytest.mark.slow
def test_its_tests_report_reversed_motors_and_encoders_and_a_missing_installation(
    package: Path, type_command: TypeCommand
) -> None:
    devices = package / "tiny_board" / "devices.py"
    code = devices.read_text().replace("turn(wheel, rad_s)", "turn(wheel, -rad_s)")
    devices.write_text(code.replace("Angle(self._board.angle(self._wheel)", "Angle(-self._board.angle(self._wheel)"))
    answer = type_command(package, *TESTS).stdout
    assert "encoders_count_forward_as_positive" not in answer
    assert "Negate the velocity of each motor that turns backward" in answer
    assert "install it first: pip install -e ." in answer


@pytest.mark.slow
def test_its_backend_is_found_and_runs_with_the_shipped_robot(package: Path, type_command: TypeCommand) -> None:
    ran = type_command(package, "robotcore", "run", "avoid-obstacles", "--backend", "tiny-board", path=install(package))
    assert ran.returncode == 0, ran.stderr
    assert "success  avoid-obstacles on tiny-board" in ran.stdout
