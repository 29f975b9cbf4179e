from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from robotcore.hal.backend import Backend, ModelExport
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.description import files
from tests.texts import CheckText

TEXTURED = """name = "hall"
[floor]
length_m = 3.0
width_m = 2.0
texture = { pattern = "planks" }
"""


@pytest.fixture
def _short_model(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace MuJoCo's model by a short text, which has a picture if there is a folder for pictures."""

    def export(_: Backend, file_format: str, robot: object, world: object, folder: str | None) -> ModelExport:
        if folder is None:
            return ModelExport("<model/>\n", notes=("1 texture left out",))
        return ModelExport(f"<model>{folder}/floor.png</model>\n", {f"{folder}/floor.png": b"PNG"})

    monkeypatch.setattr("drivers.mujoco.backend.MujocoBackend.export", export)


def test_writes_urdf_by_default(cli: Cli, tmp_path: Path) -> None:
    file = tmp_path / "rover.urdf"
    file.write_text("an older model")
    assert cli("export", "rover", "--output", str(file)) == (0, "", "")
    assert '<robot name="rover"' in file.read_text()
    assert cli("export", "rover").out == file.read_text()
    assert cli("export", "rover", "--format", "urdf").out == file.read_text()


def test_a_seed_draws_the_world_around_the_robot(cli: Cli) -> None:
    still, drawn, again, other = (
        cli("export", "rover", "--world", "arena", *seed).out
        for seed in ((), ("--seed", "7"), ("--seed", "7"), ("--seed", "8"))
    )
    assert '<link name="red-box_thing">' in still
    assert drawn == again
    assert len({still, drawn, other}) == 3


@pytest.mark.usefixtures("_short_model")
def test_puts_pictures_beside_the_file(cli: Cli, tmp_path: Path) -> None:
    file = tmp_path / "hall.xml"
    assert cli("export", "rover", "--format", "mjcf", "--output", str(file)) == (0, "", "")
    assert file.read_text() == "<model>hall_textures/floor.png</model>\n"
    assert (tmp_path / "hall_textures" / "floor.png").read_bytes() == b"PNG"
    assert cli("export", "rover", "--format", "mjcf", "--output", str(file)).status == 0


@pytest.mark.usefixtures("_short_model")
def test_bytes_that_are_not_unicode_are_left_out_of_names(cli: Cli, tmp_path: Path) -> None:
    file = tmp_path / os.fsdecode(b"hall\xff.xml")
    assert cli("export", "rover", "--format", "mjcf", "--output", str(file)).status == 0
    assert file.read_text() == "<model>hall_textures/floor.png</model>\n"
    assert (tmp_path / "hall_textures" / "floor.png").exists()


@pytest.mark.usefixtures("_short_model")
def test_notes_go_to_stderr(cli: Cli, check_text: CheckText) -> None:
    answer = cli("export", "rover", "--format", "mjcf")
    assert (answer.status, answer.out) == (0, "<model/>\n")
    check_text(answer.err)


def test_notes_that_urdf_has_no_patterns_and_lines(cli: Cli, tmp_path: Path, check_text: CheckText) -> None:
    (tmp_path / "hall.toml").write_text(TEXTURED)
    answer = cli("export", "rover", "--world", str(tmp_path / "hall.toml"))
    assert answer.status == 0
    check_text(answer.err)
    assert cli("export", "rover", "--world", "track").err == answer.err
    assert cli("export", "rover", "--world", "arena").err == ""


@pytest.mark.parametrize("arguments", [["--format", "mjfc"], ["--seed", "7"], ["--output", "missing/rover.urdf"]])
def test_wrong_arguments_are_reported(cli: Cli, arguments: list[str], check_text: CheckText) -> None:
    answer = cli("export", "rover", *arguments)
    assert (answer.status, answer.out) == (2, "")
    check_text(answer.err)


@pytest.mark.usefixtures("_short_model")
def test_a_model_without_its_pictures_is_not_written(cli: Cli, tmp_path: Path, check_text: CheckText) -> None:
    (tmp_path / "hall_textures").touch()
    answer = cli("export", "rover", "--format", "mjcf", "--output", str(tmp_path / "hall.xml"))
    assert answer.status == 2
    check_text(answer.err)
    assert not (tmp_path / "hall.xml").exists()


def test_a_full_disk_leaves_no_partial_model(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    file = tmp_path / "rover.urdf"

    def fill(to: Path, content: bytes) -> None:
        with to.open("wb") as stream:
            stream.write(content[:100])
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", fill)
    answer = cli("export", "rover", "--output", str(file))
    assert answer.status == 2
    check_text(answer.err)
    assert not file.exists()


@pytest.mark.parametrize("read", ["robot", "world"])
def test_a_description_is_not_overwritten(cli: Cli, tmp_path: Path, read: str, check_text: CheckText) -> None:
    robot, world = tmp_path / "robot.toml", tmp_path / "world.toml"
    robot.write_text(files.ROVER, encoding="utf-8")
    world.write_text(files.ARENA, encoding="utf-8")
    output = tmp_path / f"{read}.toml"
    answer = cli("export", str(robot), "--world", str(world), "--output", str(output))
    assert (answer.status, answer.out) == (2, "")
    check_text(answer.err)
    assert (robot.read_text(), world.read_text()) == (files.ROVER, files.ARENA)
