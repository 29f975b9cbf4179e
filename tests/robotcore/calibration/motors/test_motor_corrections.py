from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from robotcore.calibration.calibrated_robot import CalibratedRobot
from robotcore.calibration.least_squares import Estimate
from robotcore.calibration.motors.measurement import MotorResult
from robotcore.calibration.motors.motor_corrections import list_motor_corrections
from robotcore.calibration.motors.response import Response
from robotcore.calibration.motors.velocity_curve import VelocityCurve
from robotcore.hal.backend import load_backend

ROVER = CalibratedRobot.load("rover", load_backend("virtualpi"), {})


def build_result(
    dead_band: float = 0.1,
    forward: float = 14.0,
    backward: float = 14.0,
    lag: float = 0.05,
    instrument: str = "left_encoder",
) -> MotorResult:
    properties = [Estimate(each, each / 1000) for each in (dead_band, forward, backward)]
    curve = VelocityCurve(properties[0], properties[1], properties[2], (), 0.0, 1.0)
    return MotorResult("left_motor", instrument, curve, Response((), Estimate(lag, 0.0005), Estimate(0.0, 0.001), 0.0))


def list_needed(result: MotorResult, robot: CalibratedRobot = ROVER) -> dict[str, float]:
    return {each.name: each.new for each in list_motor_corrections(result, robot) if each.is_needed}


def test_a_file_that_is_right_needs_no_correction() -> None:
    assert list_needed(build_result()) == {}
    assert len(list_motor_corrections(build_result(), ROVER)) == 4


def test_each_property_is_corrected_in_its_table() -> None:
    assert list_needed(build_result(0.15, 13.3, 15.2, 0.08)) == {
        "raspberrypi.left_motor.model.dead_band": 0.15,
        "raspberrypi.left_motor.model.forward_rad_s": 13.3,
        "raspberrypi.left_motor.model.backward_rad_s": 15.2,
        "left_motor.lag_s": 0.08,
    }


def test_the_greatest_velocity_is_reduced_if_the_model_does_not_reach_it() -> None:
    needed = list_needed(build_result(forward=11.478))
    assert needed["left_motor.max_velocity_rad_s"] == 11.4


def test_an_error_behind_the_model_is_removed_because_the_model_contains_it() -> None:
    devices = (
        each.model_copy(update={"forward_gain": 0.9, "dead_band_rad_s": 0.3}) if each.name == "left_motor" else each
        for each in ROVER.description.devices
    )
    robot = replace(ROVER, description=ROVER.description.model_copy(update={"devices": tuple(devices)}))
    needed = list_needed(build_result(forward=12.6), robot)
    assert (needed["left_motor.forward_gain"], needed["left_motor.dead_band_rad_s"]) == (1.0, 0.0)


def on_board(**changes: Any) -> CalibratedRobot:
    return replace(ROVER, section="serial", models={}, trims={"left_motor": 1.05}, **changes)


def test_a_board_that_takes_velocities_gets_a_trim() -> None:
    slow = build_result(0.0, 12 * 0.95, 12 * 0.95)
    assert list_needed(slow, on_board()) == {"serial.left_motor.trim": pytest.approx(1.05 / 0.95, rel=1e-3)}
    assert list_needed(build_result(0.0, 12.0, 12.0), on_board()) == {}


def test_no_trim_replaces_wheels_of_other_sizes() -> None:
    """The encoders have the velocities that the board controls, so another instrument measures the wheels."""
    assert list_needed(build_result(0.0, 11.4, 11.4, instrument="gyro"), on_board()) == {}


def test_a_simulator_without_models_has_only_the_lag() -> None:
    robot = replace(ROVER, section=None, models={})
    assert [each.name for each in list_motor_corrections(build_result(), robot)] == ["left_motor.lag_s"]
