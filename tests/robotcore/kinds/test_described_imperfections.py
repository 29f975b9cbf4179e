"""Every simulator simulates the imperfections of a robot's file, and ``--ideal`` switches them off."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from robotcore import RunRequest, run
from robotcore.description import RobotDescription, load_robot, load_world
from robotcore.errors import UsageError
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.robot import Robot
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.range_sensor import RangeSensorDescription
from robotcore.runtime.plan import Plan
from robotcore.testing import MockRobot
from tests.robotcore.description.files import ROVER, find_errors
from tests.texts import Raises

SIMULATORS = ["kinematic", "mujoco", "pybullet"]
simulators = pytest.mark.parametrize("backend", SIMULATORS)

Describe = Callable[..., RobotDescription]


def describe(**changes: dict[str, Any]) -> RobotDescription:
    """Return the rover with other values of devices."""
    rover = load_robot("rover")
    devices = tuple(device.model_copy(update=changes.get(device.name, {})) for device in rover.devices)
    return rover.model_copy(update={"devices": devices})


@contextmanager
def opened(backend: str, robot: RobotDescription, *names: str, seed: int = 1) -> Iterator[Robot]:
    setup = Setup(robot, load_world("arena"), frozenset(names), seed=seed)
    with load_backend(backend).open(setup) as bare:
        yield bare


def drive(robot: Robot, command: float, seconds: float = 1.0) -> float:
    """Return the mean velocity of the left wheel in the second half of a drive, in rad/s."""
    wheel: Any = robot.devices["left_encoder"]
    for motor in robot.motors.values():
        motor.set_velocity(command)
    robot.clock.sleep_until(robot.clock.now() + seconds / 2)
    before, since = wheel.read().angle, robot.clock.now()
    robot.clock.sleep_until(since + seconds / 2)
    return float((wheel.read().angle - before) / (robot.clock.now() - since))


@simulators
@pytest.mark.parametrize(
    "command, expected", [(6.0, 12 * 0.9 * 4 / 10), (-6.0, -12 * 1.1 * 4 / 10), (1.5, 0.0), (-2.0, 0.0)]
)
def test_a_motor_has_its_dead_band_and_its_gains(backend: str, command: float, expected: float) -> None:
    change = {"dead_band_rad_s": 2.0, "forward_gain": 0.9, "backward_gain": 1.1}
    robot = describe(left_motor=change, right_motor=change)
    with opened(backend, robot, "left_motor", "right_motor", "left_encoder") as bare:
        assert drive(bare, command) == pytest.approx(expected, abs=0.06)


def test_a_motor_of_the_virtual_pi_has_the_dead_band_of_its_description() -> None:
    change = {"dead_band_rad_s": 2.0}
    robot = describe(left_motor=change, right_motor=change)
    with opened("virtualpi", robot, "left_motor", "right_motor", "left_encoder") as bare:
        assert drive(bare, 6.0) == pytest.approx(12 * 4 / 10, abs=0.1)


def test_a_motor_with_a_longer_reach_responds_as_before() -> None:
    motor = MotorDescription(
        kind="motor", name="wheel", max_velocity_rad_s=10.0, dead_band_rad_s=2.0, forward_gain=0.9, backward_gain=1.1
    )
    longer = motor.raise_max_velocity(14.0)
    assert longer.max_velocity_rad_s == 14.0
    for command in (1.0, 5.0, -7.0, 10.0):
        assert longer.respond(command) == pytest.approx(motor.respond(command))
    assert motor.raise_max_velocity(8.0) is motor


@simulators
def test_a_picture_and_a_distance_are_late(backend: str) -> None:
    late = {"latency_s": 0.15}
    robot = describe(eye=late, nose=late)
    names = ("left_motor", "right_motor", "eye", "nose")
    with opened(backend, robot, *names) as slow, opened(backend, load_robot("rover"), *names) as fast:
        history: list[tuple[float, Any, Any]] = []
        for tick in range(1, 10):
            for bare in (slow, fast):
                bare.motors["left_motor"].set_velocity(3.0)
                bare.motors["right_motor"].set_velocity(-1.0)
                bare.clock.sleep_until(tick / 20)
            history.append((fast.clock.now(), fast.range.read().distance, fast.camera.read().image))
            if tick > 3:
                time, distance, image = history[tick - 4]
                assert slow.range.read().time == slow.camera.read().time == pytest.approx(time)
                assert slow.range.read().distance == distance
                assert np.array_equal(slow.camera.read().image, image)


@simulators
def test_a_camera_has_noise_and_its_lens(backend: str) -> None:
    with opened(backend, load_robot("rover"), "eye") as bare:
        clean = bare.camera.read().image
    with opened(backend, describe(eye={"noise_levels": 5.0}), "eye") as bare:
        noisy = bare.camera.read().image
    difference = noisy.astype(int) - clean
    assert 4.0 < difference[(clean > 30) & (clean < 225)].std() < 6.0
    robot = describe(eye={"centre_px": (180.0, 110.0), "distortion": (-0.2, 0.0, 0.0, 0.0, 0.0)})
    with opened(backend, robot, "eye") as bare:
        assert bare.camera.intrinsics.cx == 180.0
        bent = bare.camera.read().image
    assert bent.shape == clean.shape
    matrix = np.array([[1, 0, -20.5], [0, 1, 9.5]], dtype=np.float32)  # near the axis, the lens only moves the picture
    moved = cv2.warpAffine(bent, matrix, (320, 240), flags=cv2.INTER_NEAREST)
    middle = np.s_[100:140, 130:190]
    assert np.abs(moved[middle].astype(int) - clean[middle]).mean() < 6.0


@pytest.mark.slow
@simulators
def test_a_range_sensor_has_its_offset_noise_and_lost_echoes(backend: str) -> None:
    def measure(**change: float) -> list[float]:
        with opened(backend, describe(nose=change), "nose") as bare:
            distances = []
            for tick in range(1, 200):
                bare.clock.sleep_until(tick / 20)
                distances.append(bare.range.read().distance)
        return distances

    true = measure()[-1]
    assert measure(offset_m=0.05)[-1] == pytest.approx(true + 0.05)
    assert 0.012 < np.std(measure(noise_m=0.015)) < 0.018
    lost = sum(map(math.isinf, measure(loss=0.3)))
    assert 40 < lost < 80


@pytest.mark.parametrize(
    "loss, samples", [(0.0, 1), (0.0005, 1), (0.02, 2), (0.1, 3), (0.2, 5), (0.5, 10), (1.0, 6905)]
)
def test_the_more_echoes_a_sensor_loses_the_more_samples_show_that_nothing_is_in_range(
    loss: float, samples: int
) -> None:
    (nose,) = describe(nose={"loss": loss}).all_of(RangeSensorDescription)
    assert nose.echo_free_samples == samples


def test_an_app_reads_the_noise_and_the_loss_from_the_sensor() -> None:
    robot = MockRobot(describe(nose={"noise_m": 0.02, "loss": 0.05}), range=1.0).layered
    assert (robot.range.noise, robot.range.echo_free_samples) == (0.02, 3)
    perfect = MockRobot(range=1.0).layered
    assert (perfect.range.noise, perfect.range.echo_free_samples) == (0.0, 1)


def test_equal_seeds_have_equal_errors_and_others_do_not() -> None:
    robot = describe(nose={"noise_m": 0.02}, eye={"noise_levels": 3.0})

    def sample(seed: int) -> tuple[float, bytes]:
        with opened("kinematic", robot, "nose", "eye", seed=seed) as bare:
            return bare.range.read().distance, bare.camera.read().image.tobytes()

    assert sample(3) == sample(3)
    assert sample(3)[0] != sample(4)[0]
    assert sample(3)[1] != sample(4)[1]


IMPERFECT = f"""{ROVER}
[[devices]]
kind = "lidar"
name = "scanner"
mount = {{ z_m = 0.1 }}
min_range_m = 0.1
max_range_m = 8.0
rate_hz = 5.0
noise_m = 0.02
latency_s = 0.1
"""


def test_ideal_devices_have_no_imperfections_and_keep_the_rest(tmp_path: Path) -> None:
    file = tmp_path / "imperfect.toml"
    file.write_text(IMPERFECT)
    plan = Plan.resolve(RunRequest("green-search", robot=str(file), ideal=True))
    (scanner,) = plan.description.all_of("lidar")
    assert (scanner.noise_m, scanner.latency_s, scanner.rate_hz) == (0.0, 0.0, 5.0)
    assert all(motor.lag_s == 0 for motor in plan.description.all_of(MotorDescription))
    assert plan.description.drive == load_robot(str(file)).drive


def test_an_ideal_run_differs_from_one_with_the_described_lag() -> None:
    request = RunRequest("avoid-obstacles", seed=7, timeout_s=10.0)
    ideal = RunRequest("avoid-obstacles", seed=7, timeout_s=10.0, ideal=True)
    assert run(request).trace_sha256 != run(ideal).trace_sha256


def test_a_real_robot_cannot_be_ideal(raises: Raises) -> None:
    with raises(UsageError, "nothing-to-idealise"):
        Plan.resolve(RunRequest("green-search", backend="raspberrypi", ideal=True))


def test_a_dead_band_of_nine_tenths_is_valid() -> None:
    motor = MotorDescription(kind="motor", name="wheel", max_velocity_rad_s=12.0, dead_band_rad_s=10.8)
    assert motor.respond(motor.compensate(0.5)) == pytest.approx(0.5)


@pytest.mark.parametrize(
    "before, after, kind",
    [
        ("max_velocity_rad_s = 12.0", "max_velocity_rad_s = 12.0\ndead_band_rad_s = 10.9", "dead-band-too-wide"),
        ("width_px = 320", "width_px = 320\ncentre_px = [400, 100]", "centre-outside"),
        ("width_px = 320", "width_px = 320\ndistortion = [-3.0, 0, 0, 0, 0]", "distortion-not-invertible"),
        ("width_px = 320", "width_px = 320\ndistortion = [0.1, 0.2]", "wrong-form"),
        ("width_px = 320", "width_px = 320\nlatency_s = -0.1", "out-of-bounds"),
        ("width_px = 320", "width_px = 320\nrate_hz = 0", "out-of-bounds"),
    ],
)
def test_a_file_with_an_impossible_imperfection_is_refused(tmp_path: Path, before: str, after: str, kind: str) -> None:
    assert before in ROVER
    (error,) = find_errors(tmp_path, ROVER.replace(before, after, 1))
    assert error.kind == kind
