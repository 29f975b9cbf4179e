from __future__ import annotations

from pathlib import Path

import pytest

from tests.robotcore.cli.conftest import Cli
from tests.robotcore.hardware.device_drivers import EYE, NECK, register, robot_file
from tests.texts import CheckText


@pytest.mark.parametrize("name", ["rover", "arena"])
def test_check_summarises_a_description(cli: Cli, name: str, check_text: CheckText) -> None:
    answer = cli("check", name)
    assert (answer.status, answer.err) == (0, "")
    check_text(answer.out.splitlines()[0])


def test_check_prints_a_warning_and_passes(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    register(monkeypatch)
    monkeypatch.setattr(
        "tests.robotcore.hardware.device_drivers.PlugBoard.warnings", lambda *_: ["neck: it wobbles. Tie it"]
    )
    file = tmp_path / "post.toml"
    file.write_text(robot_file(NECK + EYE))
    answer = cli("check", str(file))
    assert answer.status == 0
    check_text(answer.out)


def test_check_prints_all_problems_of_a_section_with_the_files_name(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    register(monkeypatch)
    file = tmp_path / "post.toml"
    file.write_text(robot_file(NECK.replace("pin", "pni") + EYE.replace("2", "10")))
    answer = cli("check", str(file))
    assert (answer.status, answer.out) == (2, "")
    assert [line.removeprefix(f"error: {file}: ").partition(":")[0] for line in answer.err.splitlines()] == [
        *("plugboard.neck.pni", "plugboard.eye.pin")
    ]


def test_check_names_a_section_that_its_backend_does_not_read(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    register(monkeypatch)
    file = tmp_path / "post.toml"
    file.write_text(robot_file(f"{NECK}{EYE}[mock]\nx = 1\n"))
    answer = cli("check", str(file))
    assert answer.status == 0
    check_text(answer.out)


def test_check_fails_if_a_section_cannot_be_checked_and_checks_the_others(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    register(monkeypatch, broken="no_such_package:Thing")
    file = tmp_path / "post.toml"
    broken = EYE.replace('"plug"', '"broken"')
    file.write_text(robot_file(f'{NECK}{broken}[raspberrypi.eye]\ndriver = "plug"\npin = 2\n[mock]\nx = 1\n'))
    answer = cli("check", str(file))
    assert answer.status == 2
    check_text(answer.err)
    file.write_text(robot_file(f"{NECK}{broken}[mock]\nx = 1\n"))
    answer = cli("check", str(file))
    assert answer.status == 3
    check_text(answer.out)


def test_check_names_the_optional_sections_of_a_world(cli: Cli, tmp_path: Path, check_text: CheckText) -> None:
    file = tmp_path / "yard.toml"
    floor = 'name = "yard"\n[floor]\nlength_m = 3.0\nwidth_m = 2.0\n'
    file.write_text(f"{floor}[conditions]\ncamera_noise = 3.0\n[randomisation]\npatterns = false\n")
    check_text(cli("check", str(file)).out)


@pytest.mark.parametrize("command", [("check",), ("run", "green-search", "--world")])
def test_all_problems_of_a_file_are_reported_in_a_line_each(cli: Cli, tmp_path: Path, command: tuple[str, ...]) -> None:
    file = tmp_path / "yard.toml"
    file.write_text('name = "Yard"\n[floor]\nlength_m = -3.0\n[flor]\n')
    answer = cli(*command, str(file))
    assert (answer.status, answer.out) == (2, "")
    assert [line.removeprefix(f"error: {file}: ").split(":")[0] for line in answer.err.splitlines()] == [
        *("name", "floor.length_m", "floor.width_m", "flor")
    ]
