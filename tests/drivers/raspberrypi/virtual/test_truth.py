"""The option `truth` of `virtualpi`: the drivers of the robot's file on the hardware of another file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import robotcore.description
from drivers.raspberrypi.virtual.backend import VirtualPiBackend
from robotcore import RunRequest, run
from robotcore.description import WorldDescription, load_robot
from robotcore.errors import DescriptionError, DeviceError, UsageError
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.hal.truth import Truth
from robotcore.kinds.servo import Servo
from robotcore.testing import worlds
from tests.texts import Raises

ROBOTS = Path(robotcore.description.__file__).parent / "robots"
WHEELS = ("left_motor", "right_motor", "left_encoder", "right_encoder")


def write_truth(folder: Path, *changes: tuple[str, str], robot: str = "rover") -> str:
    """Write a robot's file with replaced texts, and return its path. Each text must be in the file."""
    text = (ROBOTS / f"{robot}.toml").read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file = folder / "truth.toml"
    file.write_text(text, encoding="utf-8")
    return str(file)


def remove_device(name: str, section: str = "raspberrypi") -> tuple[str, str]:
    """Return the change that renames a device's table in a backend's section, so that no device is connected to it."""
    return f"[{section}.{name}]", f"[vrep.{name}_of_another_robot]"


def open_robot(truth: str, *devices: str, robot: str = "rover", world: WorldDescription | None = None) -> Robot:
    own = load_robot(robot)
    setup = Setup(own, world or worlds.empty(), frozenset(devices or WHEELS), options={"truth": truth})
    return VirtualPiBackend().open(setup)


def drive(robot: Robot, commands: Mapping[str, float], duration: float = 2.0) -> tuple[float, float]:
    """Command the motors, and return the velocities that the encoders measure after 2 s, left and right in rad/s."""
    for name, rad_s in commands.items():
        robot[name].set_velocity(rad_s)  # type: ignore[attr-defined]
    robot.clock.sleep_until(duration)
    before = [robot[f"{side}_encoder"].read().angle for side in ("left", "right")]  # type: ignore[attr-defined]
    robot.clock.sleep_until(duration + 1.0)
    after = [robot[f"{side}_encoder"].read().angle for side in ("left", "right")]  # type: ignore[attr-defined]
    return after[0] - before[0], after[1] - before[1]


def test_wheels_turn_by_the_true_model_at_the_duty_that_the_drivers_send(tmp_path: Path) -> None:
    model = "{ dead_band = 0.10, forward_rad_s = 14.0, backward_rad_s = 14.0 }"
    truth = write_truth(tmp_path, (model, "{ dead_band = 0.20, forward_rad_s = 13.0, backward_rad_s = 14.0 }"))
    with open_robot(truth) as robot:
        duty = math.floor(100 * (0.1 + 0.9 * 7 / 14)) / 100
        expected = 13 * (duty - 0.2) / 0.8
        assert drive(robot, {"left_motor": 7.0, "right_motor": 7.0}) == pytest.approx((expected, expected), abs=0.02)


def test_the_true_motor_is_not_limited_to_its_described_velocity(tmp_path: Path) -> None:
    weak = ("max_velocity_rad_s = 12.0", "max_velocity_rad_s = 6.0")
    with open_robot(write_truth(tmp_path, weak)) as robot:
        assert drive(robot, {"left_motor": 11.0}) == pytest.approx((11.0, 0.0), abs=0.2)


def test_swapped_pins_of_the_truth_swap_the_wheels_and_the_signs(tmp_path: Path) -> None:
    swapped_sides = write_truth(
        tmp_path, ("raspberrypi.left_m", "raspberrypi.x_m"), ("raspberrypi.right_m", "raspberrypi.left_m"),
        ("raspberrypi.x_m", "raspberrypi.right_m"),
    )  # fmt: skip
    with open_robot(swapped_sides) as robot:
        assert drive(robot, {"left_motor": 5.0}) == pytest.approx((0.0, 5.0), abs=0.2)
    with open_robot(write_truth(tmp_path, ("a = 5\nb = 6", "a = 6\nb = 5"))) as robot:
        assert drive(robot, {"left_motor": 5.0}) == pytest.approx((-5.0, 0.0), abs=0.2)


def test_the_ground_truth_is_that_of_the_true_robot(tmp_path: Path) -> None:
    truth = write_truth(
        tmp_path, ("wheel_radius_m = 0.0325", "wheel_radius_m = 0.0375"), ("length_m = 0.21", "length_m = 0.25")
    )
    own, world = load_robot("rover"), worlds.wall(load_robot("rover").first_of("range_sensor").mount, 3.0)
    with open_robot(truth, world=world) as robot:
        drive(robot, {"left_motor": 5.0, "right_motor": 5.0})
        assert robot.truth is not None
        true = Truth(robot.truth, own, world)
        rolled = robot["left_encoder"].read().angle * 0.0375  # type: ignore[attr-defined]
        assert true.pose.x - world.start.x_m == pytest.approx(rolled, abs=0.003)


@pytest.mark.slow
def test_a_sensor_without_a_table_never_answers(tmp_path: Path, raises: Raises) -> None:
    with open_robot(write_truth(tmp_path, remove_device("left_encoder"))) as robot:
        assert drive(robot, {"left_motor": 5.0, "right_motor": 5.0}) == pytest.approx((0.0, 5.0), abs=0.2)
    with raises(DeviceError, "trigger-unanswered", device="nose"):
        open_robot(write_truth(tmp_path, remove_device("nose")), "nose")
    with raises(DeviceError, "not-connected", device="eye"):
        open_robot(write_truth(tmp_path, remove_device("eye")), "eye", "screen")


def test_a_camera_shows_the_true_field_of_view_and_has_the_intrinsics_and_the_size_of_the_robots_file(
    tmp_path: Path,
) -> None:
    ball = worlds.empty()
    wide = ("horizontal_fov_rad = 1.0821", "horizontal_fov_rad = 1.6")
    small = ("width_px = 320\nheight_px = 240", "width_px = 160\nheight_px = 120")
    wall = worlds.wall(load_robot("rover").first_of("camera").mount, 2.0)
    with open_robot(write_truth(tmp_path, wide, small), "eye", world=wall) as robot:
        camera, frame = robot.camera, robot.camera.read()
        assert camera.intrinsics == load_robot("rover").first_of("camera").intrinsics
        assert frame.image.shape == (240, 320, 3)
    with open_robot(write_truth(tmp_path), "eye", world=wall) as robot:
        assert (robot.camera.read().image != frame.image).any()
    with (
        open_robot("rover", "eye", world=ball) as same,
        VirtualPiBackend().open(Setup(load_robot("rover"), ball, frozenset({"eye"}))) as own,
    ):
        assert (same.camera.read().image == own.camera.read().image).all()


def test_a_bus_sensor_measures_by_the_truth_and_has_the_range_of_the_robots_file(tmp_path: Path) -> None:
    ultrasonic = 'driver = "hc-sr04"\ntrigger = 16\necho = 26'
    laser = (ultrasonic, 'driver = "vl53l1x"')
    own = tmp_path / "own.toml"
    own.write_text((ROBOTS / "rover.toml").read_text(encoding="utf-8").replace(*laser), encoding="utf-8")
    moved = ("mount = { x_m = 0.14, z_m = 0.10 }\nmin_range_m", "mount = { x_m = 0.04, z_m = 0.10 }\nmin_range_m")
    longer = ("max_range_m = 2.0", "max_range_m = 3.0")
    truth = write_truth(tmp_path, laser, moved, longer)
    mount = load_robot("rover").first_of("range_sensor").mount
    for distance, measured in ((1.5, 1.6), (1.95, math.inf)):
        with open_robot(truth, "nose", robot=str(own), world=worlds.wall(mount, distance)) as robot:
            assert robot.range.max_range == 2.0
            assert robot.range.read().distance == pytest.approx(measured, abs=0.002)


def test_a_servo_turns_by_the_pulses_to_the_true_angle(tmp_path: Path) -> None:
    truth = write_truth(tmp_path, ("max_angle_rad = 1.57", "max_angle_rad = 1.0"), robot="scout")
    own = load_robot("scout")
    servo = own.first_of("servo")
    with open_robot(truth, "pan", robot="scout") as robot:
        pan = robot["pan"]
        assert isinstance(pan, Servo)
        assert pan.max_angle == servo.max_angle_rad
        pan.set_angle(1.57)
        robot.clock.sleep_until(2.0)
        state = robot.truth.simulation_state  # type: ignore[union-attr]
        assert state.joints["pan"].angle == pytest.approx(1.0)


@pytest.mark.parametrize(
    "changes, kind, fields",
    [
        ([("[raspberrypi.", "[vrep.of_")], "truth-without-section", {"section": "raspberrypi"}),
        ([('name = "screen"', 'name = "other"'), ('name = "nose"', 'name = "screen"'),
          ("raspberrypi.nose", "raspberrypi.screen"), ("serial.nose", "serial.screen"), ("vrep.nose", "vrep.of_nose")],
         "truth-of-other-kind", {"device": "screen"}),
    ],
)  # fmt: skip
def test_a_truth_of_another_robot_is_refused_before_a_device_is_opened(
    changes: list[tuple[str, str]], kind: str, fields: dict[str, Any], tmp_path: Path, raises: Raises
) -> None:
    truth = write_truth(tmp_path, *changes)
    setup = Setup(load_robot("rover"), worlds.empty(), frozenset(WHEELS), options={"truth": truth})
    with raises(UsageError, kind, **fields):
        VirtualPiBackend().notes(setup)


def test_a_truth_that_cannot_be_loaded_is_refused(tmp_path: Path, raises: Raises) -> None:
    setup = Setup(load_robot("rover"), worlds.empty(), frozenset(WHEELS))
    with raises(UsageError, "unreadable-file"):
        VirtualPiBackend().notes(replace(setup, options={"truth": str(tmp_path / "missing.toml")}))
    with raises(DescriptionError, "out-of-bounds"):
        VirtualPiBackend().notes(
            replace(setup, options={"truth": write_truth(tmp_path, ("track_m = 0.155", "track_m = 0"))})
        )
    with raises(UsageError, "truth-with-other-drive"):
        VirtualPiBackend().notes(replace(setup, robot=load_robot("lookout"), options={"truth": "rover"}))


@pytest.mark.slow
def test_the_robots_own_file_as_the_truth_changes_no_run() -> None:
    plain = run(RunRequest("avoid-obstacles", "virtualpi", seed=3, settings={"duration_s": "3"}))
    same = run(
        RunRequest("avoid-obstacles", "virtualpi", seed=3, settings={"duration_s": "3"}, options={"truth": "rover"})
    )
    assert plain.trace_sha256 == same.trace_sha256 is not None


def test_an_ideal_run_has_no_imperfections_of_the_true_robot(tmp_path: Path) -> None:
    truth = write_truth(tmp_path, ('name = "left_motor"\n', 'name = "left_motor"\nforward_gain = 0.8\n'))
    setup = Setup(load_robot("rover"), worlds.empty(), frozenset(WHEELS), options={"truth": truth})
    for is_ideal, left in ((False, 4.0), (True, 5.0)):
        with VirtualPiBackend().open(replace(setup, is_ideal=is_ideal)) as robot:
            assert drive(robot, {"left_motor": 5.0, "right_motor": 5.0}) == pytest.approx((left, 5.0), abs=0.2)
