from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from robotcore.calibration.calibrated_robot import FULL_RAD_S, CalibratedRobot
from robotcore.description import RobotDescription, load_robot, read_shipped
from robotcore.errors import DescriptionError, UsageError
from robotcore.hal.backend import load_backend
from tests.texts import Raises


def load(robot: str = "rover", backend: str = "virtualpi", **options: Any) -> CalibratedRobot:
    return CalibratedRobot.load(robot, load_backend(backend), options)


def read_excited(robot: CalibratedRobot, *, takes_duties: bool = True) -> RobotDescription:
    with robot.open_file(takes_duties=takes_duties) as file:
        return load_robot(file)


def test_an_excitation_runs_with_plain_duties_and_without_sensors_that_look_ahead() -> None:
    own, robot = load(), read_excited(load())
    assert {each.kind for each in robot.devices} == {"motor", "encoder"}
    assert robot.sensors_ahead == ()
    assert robot.drive
    assert robot.drive.max_acceleration_rad_s2 is None
    assert (robot.safety.lease_ticks, robot.safety.follow_s) == (10.0, 3600.0)
    assert robot.safety.stop_distance_m == own.description.safety.stop_distance_m
    for motor in robot.all_of("motor"):
        settings = robot.backends["raspberrypi"][motor.name]
        assert settings["model"] == {
            "dead_band": 0.0, "forward_rad_s": FULL_RAD_S, "backward_rad_s": FULL_RAD_S, "max_duty": 1.0,
        }  # fmt: skip
        assert motor.max_velocity_rad_s == own.full_rad_s == FULL_RAD_S
    assert set(robot.backends) == {"raspberrypi"}
    load_backend("virtualpi").check(robot)


def test_velocity_control_is_off_and_the_greatest_duty_holds(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    limited = "backward_rad_s = 16.0, max_duty = 0.9 }\ncontrol = {}"
    file.write_text(
        read_shipped("rover")
        .replace("backward_rad_s = 14.0 }", limited)
        .replace("forward_rad_s = 14", "forward_rad_s = 16")
    )
    own = load(str(file))
    robot = read_excited(own)
    assert own.max_command == 0.9
    assert "control" not in robot.backends["raspberrypi"]["left_motor"]
    assert robot.first_of("motor").max_velocity_rad_s == pytest.approx(9.0)
    kept = read_excited(own, takes_duties=False)
    assert kept.drive == own.description.drive
    assert kept.backends["raspberrypi"]["left_motor"]["control"] == {}
    assert kept.safety == own.description.safety


def test_a_run_compensates_no_described_error_of_a_motor_that_takes_duties(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(read_shipped("rover").replace("lag_s = 0.05", "forward_gain = 0.9\ndead_band_rad_s = 0.5"))
    own = load(str(file))
    assert not own.description.first_of("motor").is_exact
    assert read_excited(own).first_of("motor").is_exact
    assert not read_excited(own, takes_duties=False).first_of("motor").is_exact


def test_a_servo_that_steers_stays() -> None:
    assert {each.kind for each in read_excited(load("picar")).devices} == {"motor", "encoder", "servo"}


def test_motors_without_models_are_measured_by_their_velocities() -> None:
    own = load(backend="kinematic")
    assert (own.section, own.full_rad_s, own.max_command) == (None, 12.0, 1.0)
    assert read_excited(own).all_of("motor") == own.description.all_of("motor")


def test_the_simulated_hardware_of_virtualpi_is_that_of_the_robots_own_file() -> None:
    assert load().options == {"truth": "rover"}
    assert load(truth="true.toml").options == {"truth": "true.toml"}
    assert load(backend="kinematic").options == {}


def test_a_robot_that_cannot_be_calibrated_is_refused(tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "no-drive", robot="lookout"):
        load("lookout")
    file = tmp_path / "own.toml"
    file.write_text(read_shipped("rover").replace("[raspberrypi.", "[vrep.of_"))
    with raises(DescriptionError, "no-section"):
        load(str(file))
