from __future__ import annotations

from pathlib import Path

import pytest

from tests.robotcore.cli.conftest import Cli
from tests.robotcore.hardware.device_drivers import EYE, NECK, register, robot_file


@pytest.mark.parametrize(
    "name, summary",
    [
        ("rover", "the robot 'rover': 2 motors, 2 encoders, 1 range sensor, 1 camera, 1 display"),
        ("arena", "the world 'arena': 4 m x 4 m, 6 obstacles, 1 target"),
    ],
)
def test_check_says_what_is_described(cli: Cli, name: str, summary: str) -> None:
    answer = cli("check", name)
    assert (answer.status, answer.out.splitlines()[0], answer.err) == (0, f"{name}: OK, {summary}", "")


def test_check_lets_a_backend_check_its_own_section(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    register(monkeypatch)
    file = tmp_path / "post.toml"
    file.write_text(robot_file(NECK + EYE))
    assert cli("check", str(file)).out.splitlines()[1:] == [f"{file}: [plugboard] OK, 2 plugs"]


def test_check_tells_what_may_do_harm_and_passes(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    register(monkeypatch)
    monkeypatch.setattr(
        "tests.robotcore.hardware.device_drivers.PlugBoard.warnings", lambda *_: ["neck: it wobbles. Tie it"]
    )
    file = tmp_path / "post.toml"
    file.write_text(robot_file(NECK + EYE))
    answer = cli("check", str(file))
    assert answer.status == 0
    assert answer.out.splitlines()[2:] == [f"{file}: [plugboard] warning: neck: it wobbles. Tie it"]


def test_check_tells_all_that_is_wrong_with_a_section_by_the_files_own_name(
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


def test_check_says_which_section_no_backend_reads(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    register(monkeypatch)
    file = tmp_path / "post.toml"
    file.write_text(robot_file(f"{NECK}{EYE}[kinematic]\nx = 1\n"))
    answer = cli("check", str(file))
    assert answer.status == 0
    assert f"{file}: [kinematic] was not checked: the backend reads no section" in answer.out.splitlines()


def test_check_fails_where_a_section_cannot_be_checked_and_checks_the_others_all_the_same(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    register(monkeypatch, broken="no_such_package:Thing")
    file = tmp_path / "post.toml"
    broken = EYE.replace('"plug"', '"broken"')
    file.write_text(robot_file(f'{NECK}{broken}[raspberrypi.eye]\ndriver = "plug"\npin = 2\n[kinematic]\nx = 1\n'))
    answer = cli("check", str(file))
    assert answer.status == 2
    assert "raspberrypi.neck: is missing" in answer.err
    file.write_text(robot_file(f"{NECK}{broken}[kinematic]\nx = 1\n"))
    answer = cli("check", str(file))
    assert answer.status == 3
    assert [line.removeprefix(f"{file}: ").partition(",")[0] for line in answer.out.splitlines()] == [
        *("OK", "[kinematic] was not checked: the backend reads no section")
    ]
    assert answer.err.startswith(f"error: {file}: [plugboard] was not checked: the device driver 'broken'")
    assert "no_such_package" in answer.err


def test_check_reads_a_users_own_file(cli: Cli, tmp_path: Path) -> None:
    file = tmp_path / "yard.toml"
    file.write_text('name = "yard"\n[floor]\nlength_m = 3.0\nwidth_m = 2.0\n')
    answer = cli("check", str(file))
    assert answer.out == f"{file}: OK, the world 'yard': 3 m x 2 m, 0 obstacles, 0 targets (nothing to search for)\n"


def test_check_says_which_sections_a_world_has_of_its_own(cli: Cli, tmp_path: Path) -> None:
    file = tmp_path / "yard.toml"
    floor = 'name = "yard"\n[floor]\nlength_m = 3.0\nwidth_m = 2.0\n'
    file.write_text(f"{floor}[conditions]\ncamera_noise = 3.0\n[randomisation]\npatterns = false\n")
    assert cli("check", str(file)).out.endswith(", conditions of its own, randomisation of its own\n")


def test_check_tells_a_fault_in_one_line(cli: Cli, tmp_path: Path) -> None:
    file = tmp_path / "yard.toml"
    file.write_text('name = "yard"\n[floor]\nlength_m = -3.0\nwidth_m = 2.0\n')
    answer = cli("check", str(file))
    assert (answer.status, answer.out) == (2, "")
    assert answer.err.startswith(f"error: {file}: floor.length_m: ")
    assert len(answer.err.splitlines()) == 1


@pytest.mark.parametrize("command", [("check",), ("run", "green-search", "--world")])
def test_all_faults_of_a_file_are_reported_a_line_each(cli: Cli, tmp_path: Path, command: tuple[str, ...]) -> None:
    file = tmp_path / "yard.toml"
    file.write_text('name = "Yard"\n[floor]\nlength_m = -3.0\n[flor]\n')
    answer = cli(*command, str(file))
    assert (answer.status, answer.out) == (2, "")
    assert [line.removeprefix(f"error: {file}: ").split(":")[0] for line in answer.err.splitlines()] == [
        *("name", "floor.length_m", "floor.width_m", "flor")
    ]
