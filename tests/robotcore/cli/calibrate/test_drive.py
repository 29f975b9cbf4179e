from __future__ import annotations

import io
import math
import re
from pathlib import Path
from typing import Any

import pytest

from robotcore.calibration.calibrated_robot import CalibratedRobot
from robotcore.calibration.excitation import TruePoseObserver
from robotcore.calibration.excitation_runs import Displacement, ExcitationRunner
from robotcore.cli.person import TerminalPerson
from robotcore.description import load_robot
from robotcore.geometry import wrap_angle
from tests.robotcore.cli.calibrate.robots import IMU, NO_ENCODERS, SLOW_LEFT_MOTOR, Changes, write_robot
from tests.robotcore.cli.conftest import Cli
from tests.texts import CheckText

pytestmark = pytest.mark.slow

OTHER_DRIVE: Changes = (("track_m = 0.155", "track_m = 0.149"), ("wheel_radius_m = 0.0325", "wheel_radius_m = 0.0338"))
ROOM = """
name = "room"
[floor]
length_m = 3.0
width_m = 3.6
[walls]
height_m = 0.4
[start]
x_m = -0.4
y_m = 0.6
"""


def calibrate(cli: Cli, robot: str, *more: str) -> Any:
    return cli("calibrate", "drive", "--backend", "virtualpi", "--robot", robot, *more)


def with_truth(truth: str) -> tuple[str, str]:
    return "--option", f"truth={truth}"


@pytest.mark.parametrize("by", ["tape", "imu", "wall"])
def test_radius_and_track_are_corrected_to_the_truth(cli: Cli, tmp_path: Path, by: str) -> None:
    room = tmp_path / "room.toml"
    room.write_text(ROOM)
    own, truth = write_robot(tmp_path, "own", more=IMU), write_robot(tmp_path, "truth", *OTHER_DRIVE, more=IMU)
    walls = ("--world", str(room), "--straight-by", "wall", "--distance", "1") if by == "wall" else ()
    answer = calibrate(cli, own, *with_truth(truth), "--turns-by", by, *walls, "--turns", "3", "--write")
    assert answer.status == 0, answer.err
    drive = load_robot(own).drive
    assert drive
    assert drive.wheel_radius_m == pytest.approx(0.0338, rel=0.002)
    assert drive.track_m == pytest.approx(0.149, rel=0.006 if by == "wall" else 0.003)


@pytest.mark.parametrize("has_encoders", [True, False])
def test_motors_with_different_lags_are_no_wheels_of_different_sizes(
    cli: Cli, tmp_path: Path, *, has_encoders: bool
) -> None:
    without = () if has_encoders else NO_ENCODERS
    own, truth = (
        write_robot(tmp_path, name, *SLOW_LEFT_MOTOR, *radius, *without)
        for name, radius in (("own", ()), ("truth", (("wheel_radius_m = 0.0325", "wheel_radius_m = 0.0334"),)))
    )
    answer = calibrate(cli, own, *with_truth(truth), "--turns", "2", "--json")
    assert answer.json["wheel_radius_m"]["value"] == pytest.approx(0.0334, rel=0.001)
    ratio = answer.json["radius_ratio"]
    assert ratio["value"] == pytest.approx(1.0, abs=0.001)
    assert ratio["deviation"] > (0.0015 if has_encoders else 0.01)


def test_wheels_of_different_sizes_are_named(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read = ExcitationRunner.read_displacement

    def bend(runner: ExcitationRunner, keeper: TruePoseObserver) -> Displacement | None:
        moved = read(runner, keeper)
        return moved and Displacement(moved.forward_m, moved.left_m + 0.13)  # as if the right wheels were 1 % larger

    monkeypatch.setattr(ExcitationRunner, "read_displacement", bend)
    answer = calibrate(cli, write_robot(tmp_path, "own", *SLOW_LEFT_MOTOR), "--turns", "2")
    assert re.search(r"The radius of the right wheels is 1\.0\d+ ± 0\.00\d+ of that of the left wheels", answer.out)


def test_the_effective_track_of_wheels_that_skid_is_their_factor(cli: Cli) -> None:
    answer = calibrate(cli, "freenove-4wd", "--json")
    assert [each["key"] for each in answer.json["corrections"]] == ["drive.wheel_radius_m", "drive.track_factor"]
    assert not any(each["is_needed"] for each in answer.json["corrections"])


def test_a_robot_that_steers_has_only_a_radius(cli: Cli, tmp_path: Path) -> None:
    answer = calibrate(cli, "picar", "--plot", str(tmp_path / "drive.png"))
    assert "Not measured: track_m, wheelbase_m, and the angles of the steering servo" in answer.out
    assert (tmp_path / "drive.png").exists()


def test_a_reference_that_the_robot_lacks_is_refused(cli: Cli, check_text: CheckText) -> None:
    answer = calibrate(cli, "rover", "--turns-by", "imu")
    assert answer.status == 2
    check_text(answer.err)


@pytest.fixture
def real_robot(monkeypatch: pytest.MonkeyPatch) -> list[TruePoseObserver]:
    """Hide the ground truth from the calibration, and return the keepers that know it."""
    keepers: list[TruePoseObserver] = []
    begin = TruePoseObserver.begin

    def hide(keeper: TruePoseObserver, run: Any) -> None:
        hidden = TruePoseObserver()
        begin(hidden, run)
        keepers.append(hidden)

    def forward(keeper: TruePoseObserver, record: Any) -> None:
        TICK(keepers[-1], record)

    monkeypatch.setattr(TruePoseObserver, "begin", hide)
    monkeypatch.setattr(TruePoseObserver, "tick", forward)
    monkeypatch.setattr(CalibratedRobot, "is_simulated", False)
    return keepers


TICK = TruePoseObserver.tick


def test_a_person_measures_a_real_robot(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, real_robot: list[TruePoseObserver]
) -> None:
    own, truth = write_robot(tmp_path, "own"), write_robot(tmp_path, "truth", *OTHER_DRIVE)

    def read_line(_person: TerminalPerson, prompt: str) -> str:
        """Answer a question about the last motion. A question about a distance comes in two parts."""
        prompts.append(prompt)
        if "press Enter" in prompt:
            return ""
        keeper = real_robot[-1]
        assert keeper.displacement
        if "degrees" in prompt:
            return f"{math.degrees(wrap_angle(keeper.turned)):.1f}"
        return f"{abs(keeper.displacement[0]) if 'along' in prompt else keeper.displacement[1]:.3f}"

    prompts: list[str] = []
    monkeypatch.setattr("robotcore.cli.person.has_terminal", lambda: True)
    monkeypatch.setattr(TerminalPerson, "read_line", read_line)
    answer = calibrate(cli, own, *with_truth(truth), "--turns-by", "tape", "--turns", "3", "--write")
    assert answer.status == 0, answer.err
    drive = load_robot(own).drive
    assert drive
    assert drive.wheel_radius_m == pytest.approx(0.0338, rel=0.002)
    assert drive.track_m == pytest.approx(0.149, rel=0.003)
    assert (
        sum("the angle from the line" in each for each in prompts) == 3
    )  # one turn first, so that the rest of many turns is clear


@pytest.mark.parametrize("more", [(), ("--yes",)], ids=["asks", "yes"])
def test_without_a_person_who_measures_a_real_robot_does_not_move(
    more: tuple[str, ...],
    cli: Cli,
    monkeypatch: pytest.MonkeyPatch,
    real_robot: list[TruePoseObserver],
    check_text: CheckText,
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    answer = calibrate(cli, "rover", *more)
    assert (answer.status, real_robot) == (2, [])
    check_text(answer.err)


def test_a_person_is_asked_again_after_an_impossible_answer(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], check_text: CheckText
) -> None:
    answers = iter(["1e308", "-101", "nan", "one", "1,5"])
    monkeypatch.setattr(TerminalPerson, "read_line", lambda *_: next(answers))
    assert TerminalPerson().ask("the distance in metres", 100.0) == 1.5
    check_text(capsys.readouterr().err)
