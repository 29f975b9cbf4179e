from __future__ import annotations

import signal
from pathlib import Path
from typing import Any

import cv2
import pytest

from robotcore.calibration.calibrated_robot import CalibratedRobot
from robotcore.calibration.excitation import ExcitationLog
from robotcore.description import load_robot
from tests.robotcore.cli.calibrate.robots import (
    ARDUINO_MOTORS,
    DEAD_ENCODER,
    IMU,
    NO_ENCODERS,
    OTHER_MOTORS,
    REVERSED_ENCODER,
    SLOW_LEFT_MOTOR,
    Changes,
    write_robot,
)
from tests.robotcore.cli.conftest import Cli
from tests.texts import CheckText

pytestmark = pytest.mark.slow


def calibrate(cli: Cli, robot: str, truth: str | None = None, *more: str) -> Any:
    options = ("--option", f"truth={truth}") if truth else ()
    return cli("calibrate", "motors", "--backend", "virtualpi", "--robot", robot, *options, *more)


def read_motors(file: str) -> dict[str, tuple[float, ...]]:
    robot = load_robot(file)
    tables = {each.name: (robot.backends["raspberrypi"][each.name]["model"], each) for each in robot.all_of("motor")}
    return {
        name: (model["dead_band"], model["forward_rad_s"], model["backward_rad_s"], motor.lag_s)
        for name, (model, motor) in tables.items()
    }


@pytest.mark.parametrize("method, digits", [("encoder", 0.003), ("imu", 0.01)])
def test_the_file_is_corrected_to_the_truth(cli: Cli, tmp_path: Path, method: str, digits: float) -> None:
    own, truth = write_robot(tmp_path, "own", more=IMU), write_robot(tmp_path, "truth", *OTHER_MOTORS, more=IMU)
    answer = calibrate(cli, own, truth, "--by", method, "--write")
    assert answer.status == 0, answer.err
    assert f"{own} has been corrected." in answer.out
    assert "later than" not in answer.out
    for name, values in read_motors(truth).items():
        assert read_motors(own)[name] == pytest.approx(values, rel=digits)
    again = calibrate(cli, own, truth, "--by", method)
    assert "There is nothing to correct." in again.out


def test_wheels_without_a_lag_are_measured(cli: Cli, tmp_path: Path) -> None:
    own, truth = write_robot(tmp_path, "own"), write_robot(tmp_path, "truth", ("lag_s = 0.05", "lag_s = 0.0"))
    assert calibrate(cli, own, truth, "--write").status == 0
    assert {motor: values[1:] for motor, values in read_motors(own).items()} == {
        motor: pytest.approx(values[1:], rel=0.001, abs=0.002) for motor, values in read_motors(truth).items()
    }


def test_a_motor_with_a_lag_beyond_the_limit_is_named_and_nothing_is_written(
    cli: Cli, tmp_path: Path, check_text: CheckText
) -> None:
    own, truth = write_robot(tmp_path, "own"), write_robot(tmp_path, "truth", ("lag_s = 0.05", "lag_s = 5.0"))
    before = Path(own).read_text()
    answer = calibrate(cli, own, truth, "--write", "--json")
    assert (answer.status, answer.json["kind"]) == (1, "parameter-at-limit")
    assert Path(own).read_text() == before
    check_text(answer.err)


def test_motors_with_different_lags_are_named(cli: Cli, tmp_path: Path) -> None:
    answer = calibrate(cli, write_robot(tmp_path, "own"), write_robot(tmp_path, "truth", *SLOW_LEFT_MOTOR))
    assert "The left wheels follow a command 100 ms later than the right wheels" in answer.out
    assert "turns to the left when it starts. The manoeuvre straight corrects this by the encoders" in answer.out
    assert "e-0" not in answer.out


def test_a_tape_measure_gives_all_but_the_lag(cli: Cli, tmp_path: Path) -> None:
    own, truth = write_robot(tmp_path, "own"), write_robot(tmp_path, "truth", *OTHER_MOTORS)
    answer = calibrate(cli, own, truth, "--by", "tape", "--json")
    for motor, (dead_band, forward, backward, _) in read_motors(truth).items():
        found = answer.json["motors"][motor]
        assert found["dead_band"]["value"] == pytest.approx(dead_band, rel=0.02)
        assert found["forward_rad_s"]["value"] == pytest.approx(forward, rel=0.01)
        assert found["backward_rad_s"]["value"] == pytest.approx(backward, rel=0.01)
        assert "lag_s" not in found


def test_a_stand_in_for_a_board_corrects_no_file(cli: Cli, tmp_path: Path) -> None:
    """The simulator's own motor has no dead band, so its model is not that of the file."""
    own = write_robot(tmp_path, "own", *ARDUINO_MOTORS, *NO_ENCODERS)
    before = Path(own).read_text()
    answer = calibrate(cli, own, None, "--write", "--json")
    assert not answer.json["is_written"]
    assert Path(own).read_text() == before
    assert "stays as it is: virtualpi does not run the driver of left_motor, right_motor" in calibrate(cli, own).out


def test_without_write_the_file_stays_and_the_answer_has_the_diff(cli: Cli, tmp_path: Path) -> None:
    own, truth = write_robot(tmp_path, "own"), write_robot(tmp_path, "truth", *OTHER_MOTORS)
    before, plot = Path(own).read_text(), tmp_path / "motors.png"
    answer = calibrate(cli, own, truth, "--json", "--plot", str(plot))
    assert Path(own).read_text() == before
    assert answer.json["is_written"] is False
    assert "+lag_s = 0.08" in answer.json["diff"]
    needed = {each["key"] for each in answer.json["corrections"] if each["is_needed"]}
    assert {"left_motor.lag_s", "raspberrypi.right_motor.model.dead_band"} <= needed
    picture = cv2.imread(str(plot))
    assert picture is not None
    assert picture.shape[1] > 1000


def test_a_shipped_robot_is_measured_but_not_written(cli: Cli, check_text: CheckText) -> None:
    answer = calibrate(cli, "rover")
    assert "There is nothing to correct." in answer.out
    refused = calibrate(cli, "rover", None, "--write")
    assert refused.status == 2
    check_text(refused.err)


@pytest.mark.parametrize(
    "changes, kind", [(DEAD_ENCODER, "no-motion"), (REVERSED_ENCODER, "counts-backward")], ids=["dead", "reversed"]
)
def test_a_faulty_encoder_is_named_and_nothing_is_written(
    cli: Cli, tmp_path: Path, changes: Changes, kind: str, check_text: CheckText
) -> None:
    own, truth = write_robot(tmp_path, "own"), write_robot(tmp_path, "truth", *changes)
    before = Path(own).read_text()
    answer = calibrate(cli, own, truth, "--write", "--json")
    assert (answer.status, answer.json["kind"]) == (1, kind)
    assert Path(own).read_text() == before
    check_text(answer.err)


def test_a_real_robot_moves_only_after_a_confirmation(
    cli: Cli, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr(CalibratedRobot, "is_simulated", False)
    monkeypatch.setattr("sys.stdin", None)
    refused = calibrate(cli, "rover")
    assert refused.status == 2
    check_text(refused.err)
    assert calibrate(cli, "rover", None, "--yes").status == 0


def test_an_interruption_ends_the_run_and_leaves_the_file(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own, truth = write_robot(tmp_path, "own"), write_robot(tmp_path, "truth", *OTHER_MOTORS)
    before, add, sent = Path(own).read_text(), ExcitationLog.add_sent, []

    def interrupt(log: ExcitationLog, time: float, velocities: Any) -> None:
        add(log, time, velocities)
        sent.append(time)
        if len(sent) == 300:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(ExcitationLog, "add_sent", interrupt)
    answer = calibrate(cli, own, truth, "--write")
    assert answer.status == 130
    assert Path(own).read_text() == before
    assert len(sent) < 310


@pytest.mark.parametrize(
    "arguments",
    [
        ("--by", "imu"),
        ("--plot", "motors.jpg"),
        ("--robot", "lookout"),
        ("--robot", "missing.toml"),
        ("--backend", "nowhere"),
    ],
    ids=lambda arguments: arguments[1],
)
def test_a_calibration_that_is_not_possible_is_refused(
    cli: Cli, arguments: tuple[str, ...], check_text: CheckText
) -> None:
    answer = calibrate(cli, "rover", None, *arguments)
    assert answer.status == 2
    check_text(answer.err)
