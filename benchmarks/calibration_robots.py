"""Robots on `virtualpi` whose files are wrong: the true values are drawn, and a calibration measures them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from random import Random
from typing import NoReturn

import tomlkit

from robotcore import RunRequest, run
from robotcore.autonomy.manoeuvres import straight
from robotcore.autonomy.routines import Routine
from robotcore.calibration.calibrated_robot import CalibratedRobot
from robotcore.calibration.excitation import TruePoseObserver
from robotcore.calibration.excitation_runs import Displacement, ExcitationRunner
from robotcore.description import read_shipped
from robotcore.description.editing import RobotEditor
from robotcore.errors import BlockedError
from robotcore.geometry import Pose
from robotcore.hal.backend import load_backend
from robotcore.hal.robot import Robot, Role
from robotcore.runtime.behaviour import Behaviour, Status

BACKEND, SECTION, WORLD = "virtualpi", "raspberrypi", "open"
MOTORS = ("left_motor", "right_motor")
KEYS = ("dead_band", "forward_rad_s", "backward_rad_s")

TAPE_M, ANGLE_RAD, ALIGNMENT_RAD = 0.002, math.radians(1.0), math.radians(0.5)
"""The standard deviations of a distance and an angle by a person, and of the direction in which the robot is put."""

IMU = """
[[devices]]
kind = "imu"
name = "gyro"
yaw_rate_noise_rad_s = {noise}
yaw_rate_bias_rad_s = {bias}

[raspberrypi.gyro]
driver = "mpu6050"
"""


patient_run = partial(run, timeout_scale=30.0)
"""Performs a run on a busy machine."""


@dataclass(frozen=True)
class Patient:
    """A robot whose file is wrong, and the file of the true robot."""

    own: str
    truth: str
    values: dict[str, dict[str, float]]
    """The true values of each motor."""


def draw_patient(folder: Path, seed: int, *, has_encoders: bool = True, has_equal_lags: bool = False) -> Patient:
    """Write the file of a rover, and that of the true robot whose motors are drawn.

    The dead band is from 4 % to 25 %, and the lag from 20 ms to 150 ms. The gains of both motors and of both directions
    differ by up to 10 % from 14 rad/s.

    has_encoders: whether the robot has encoders.
    has_equal_lags: whether both motors have the same lag, as two motors of one type have.
    """
    draw = Random(seed)
    text = read_shipped("rover") if has_encoders else _remove_encoders(read_shipped("rover"))
    own, truth = folder / f"own_{seed}.toml", folder / f"truth_{seed}.toml"
    own.write_text(text + IMU.format(noise=0.0, bias=0.0), encoding="utf-8")
    truth.write_text(text + IMU.format(noise=0.005, bias=round(draw.uniform(-0.03, 0.03), 4)), encoding="utf-8")
    values = {
        motor: {
            "dead_band": draw.uniform(0.04, 0.25),
            "forward_rad_s": 14 * draw.uniform(0.9, 1.1),
            "backward_rad_s": 14 * draw.uniform(0.9, 1.1),
            "lag_s": draw.uniform(0.02, 0.15),
        }
        for motor in MOTORS
    }
    if has_equal_lags:
        values[MOTORS[1]]["lag_s"] = values[MOTORS[0]]["lag_s"]
    editor = RobotEditor(str(truth))
    for motor, true in values.items():
        editor.set_device(motor, lag_s=true["lag_s"])
        editor.set_section(SECTION, motor, model={key: true[key] for key in KEYS})
    editor.write()
    return Patient(str(own), str(truth), values)


def _remove_encoders(text: str) -> str:
    robot = tomlkit.parse(text).unwrap()
    robot = {key: robot[key] for key in ("name", "body", "drive", "safety", "devices", SECTION)}
    robot["devices"] = [each for each in robot["devices"] if each["kind"] != "encoder"]
    for side in ("left", "right"):
        del robot["drive"][f"{side}_encoder"], robot[SECTION][f"{side}_encoder"]
    return tomlkit.dumps(robot)


class NoPerson:
    """There is no person beside a simulated robot."""

    def prepare(self, instruction: str, *, has_question: bool = False) -> NoReturn:
        raise AssertionError(instruction)

    def ask(self, question: str, most: float = 360.0) -> NoReturn:
        raise AssertionError(question)


class InaccurateTape(ExcitationRunner):
    """Measures the displacement with the errors of a person with a tape measure."""

    draw = Random(0)

    def read_displacement(self, keeper: TruePoseObserver) -> Displacement | None:
        if (true := super().read_displacement(keeper)) is None:
            return None
        seen = Pose(0.0, 0.0, self.draw.gauss(0.0, ALIGNMENT_RAD)).to_local(*true)
        return Displacement(*(self.draw.gauss(each, TAPE_M) for each in seen))

    def read_turn(self, keeper: TruePoseObserver) -> float | None:
        return None if (true := super().read_turn(keeper)) is None else self.draw.gauss(true, ANGLE_RAD)


def open_runner(patient: Patient, seed: int = 0) -> ExcitationRunner:
    """Return the runner of a robot."""
    robot = CalibratedRobot.load(patient.own, load_backend(BACKEND), {"truth": patient.truth})
    runner = InaccurateTape(robot, patient_run, NoPerson(), WORLD)
    runner.draw = Random(seed)
    return runner


class DriveStraight(Behaviour):
    """Drives straight by the commands alone, or by the manoeuvre, which holds the heading by the odometry."""

    needs = frozenset({Role.DRIVE})

    def __init__(self, distance_m: float, speed_m_s: float, *, holds_heading: bool) -> None:
        self._distance, self._speed, self._holds_heading = distance_m, speed_m_s, holds_heading

    def run(self, robot: Robot) -> Routine[Status]:
        if self._holds_heading:
            yield from straight(robot, self._distance, speed=self._speed)
        end = robot.clock.now() + self._distance / self._speed
        while not self._holds_heading and robot.clock.now() < end:
            robot.drive.set_velocity(self._speed, 0.0)
            yield
        return Status.SUCCESS


def measure_aside_m(patient: Patient, distance_m: float, speed_m_s: float, *, holds_heading: bool) -> float:
    """Drive straight, and return how far the robot is aside in the end, by the ground truth, in metres.

    A robot whose file has a dead band that is too narrow may get stuck shortly before the end.
    """
    keeper = TruePoseObserver()
    app = DriveStraight(distance_m, speed_m_s, holds_heading=holds_heading)
    result = patient_run(RunRequest(app, BACKEND, patient.own, WORLD, options={"truth": patient.truth}), [keeper])
    assert result.error is None or result.error.kind == BlockedError.kind, result.error  # type: ignore[attr-defined]
    assert keeper.displacement
    return keeper.displacement[1]
