from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from robotcore.description import RobotDescription, load_robot
from robotcore.errors import BackendError, DescriptionError, DeviceError, DeviceGroupError, UsageError
from robotcore.hal.backend import Setup
from robotcore.hal.devices import Camera, MemoryDisplay
from robotcore.hal.robot import Robot
from robotcore.simulation.remote_scene import (
    CameraOptics,
    ObjectKind,
    Owner,
    SceneObject,
    State,
    inspect_scene,
    open_in_scene,
)
from robotcore.testing import worlds
from tests.robotcore.simulation.remote_scene.memory import MemoryScene, rover

Change = Callable[[MemoryScene], object]


def setup_of(robot: RobotDescription, *devices: str, rate_hz: float = 20.0) -> Setup:
    names = devices or tuple(device.name for device in robot.devices)
    return Setup(robot, worlds.empty(), frozenset(names), rate_hz)


def joined(scene: MemoryScene, setup: Setup, whose: Owner = Owner.OURS) -> Robot:
    return open_in_scene(setup, "memory", lambda: scene, whose)


def changed(setup: Setup, change: Change, state: State = State.STOPPED) -> MemoryScene:
    scene = MemoryScene(setup, state)
    change(scene)
    return scene


def without(path: str, scene: MemoryScene) -> None:
    scene.objects_there = [thing for thing in scene.objects_there if thing.path != path]


def test_stopped_simulation_is_started_and_stopped_again_motors_first() -> None:
    setup = setup_of(rover())
    with joined(scene := MemoryScene(setup), setup) as robot:
        assert scene.diary == ["start", "left_motor 0", "right_motor 0"]
        robot.motors["left_motor"].set_velocity(2.0)
        scene.diary.clear()
    assert scene.diary[:2] == ["left_motor 0", "right_motor 0"]
    assert scene.diary[-2:] == ["stop", "leave"]


def test_running_simulation_is_left_running() -> None:
    setup = setup_of(rover())
    with joined(scene := MemoryScene(setup, State.RUNNING), setup):
        pass
    assert "stop" not in scene.diary
    assert scene.diary[-1] == "leave"


@pytest.mark.parametrize(
    "state, whose, words",
    [
        (State.PAUSED, Owner.OURS, "the simulation is paused"),
        (State.STOPPED, Owner.THEIRS, "simulation=theirs"),
    ],
)
def test_simulation_that_is_not_ours_to_start_is_refused_and_left_alone(state: State, whose: Owner, words: str) -> None:
    setup = setup_of(rover())
    scene = MemoryScene(setup, state)
    with pytest.raises(BackendError, match=words):
        joined(scene, setup, whose)
    assert scene.diary == ["leave"]


def test_section_that_is_wrong_is_reported_before_anybody_connects() -> None:
    setup = setup_of(load_robot("rover").model_copy(update={"backends": {}}))
    with pytest.raises(DescriptionError):
        open_in_scene(setup, "memory", lambda: pytest.fail("connected"))


def test_all_that_is_missing_is_reported_at_once_with_what_was_probably_meant() -> None:
    setup = setup_of(rover(nose={"path": "/rover/nos"}, eye={"path": "/rover/leftMotor"}))
    scene = MemoryScene(setup)
    with pytest.raises(DeviceGroupError) as refused:
        joined(scene, setup)
    words = str(refused.value)
    assert "nose: the scene has no object '/rover/nos'. Did you mean '/rover/nose'?" in words
    assert "eye: '/rover/leftMotor' is a joint, expected a vision sensor" in words
    assert scene.diary == ["leave"]


@pytest.mark.parametrize(
    "change, words",
    [
        (partial(without, "/v1"), "screen: the scene has no object '/v1'"),
        (
            lambda scene: setattr(scene, "eye", CameraOptics(256, 256, 1.0821)),
            "256x256 pixels.*320x240 pixels.*as_found",
        ),
        (lambda scene: setattr(scene, "eye", CameraOptics(320, 240, 0.5)), r"28.6 degrees.*62.0 degrees"),
        (lambda scene: setattr(scene, "blind", "it sees nothing. Install it"), "nose: it sees nothing. Install it"),
    ],
)
def test_object_that_does_not_fit_is_refused_before_anything_runs(change: Change, words: str) -> None:
    setup = setup_of(rover())
    scene = changed(setup, change)
    with pytest.raises(DeviceError, match=words):
        joined(scene, setup)
    assert "start" not in scene.diary


def test_two_motors_on_one_joint_are_refused() -> None:
    setup = setup_of(rover(right_motor={"path": "/rover/leftMotor"}), "left_motor", "right_motor")
    with pytest.raises(DeviceError, match=r"right_motor: its joint '/rover/leftMotor' is left_motor's too"):
        joined(MemoryScene(setup), setup)


def test_rate_that_does_not_fit_the_time_step_is_refused_before_anything_runs() -> None:
    setup = setup_of(rover(), rate_hz=30.0)
    scene = MemoryScene(setup)
    with pytest.raises(UsageError, match="Take --rate 20"):
        joined(scene, setup)
    assert scene.diary == ["leave"]


def test_screen_that_a_scene_may_do_without_is_kept_in_memory() -> None:
    setup = setup_of(rover(screen={"path": "/v1", "optional": True}))
    with joined(changed(setup, partial(without, "/v1")), setup) as robot:
        assert isinstance(robot.display, MemoryDisplay)


def test_camera_as_found_has_the_scenes_intrinsics() -> None:
    setup = setup_of(rover(eye={"path": "/rover/eye", "as_found": True}), "eye")
    scene = changed(setup, lambda scene: setattr(scene, "eye", CameraOptics(256, 128, 1.0)))
    with joined(scene, setup) as robot:
        seen = robot.camera.intrinsics
    assert (seen.width, seen.height, seen.horizontal_fov) == (256, 128, 1.0)


def test_picture_of_another_size_in_mid_run_is_an_error() -> None:
    setup = setup_of(rover(eye={"path": "/rover/eye", "as_found": True}), "eye")
    scene = changed(setup, lambda scene: setattr(scene, "eye", CameraOptics(256, 128, 1.0)))
    with joined(scene, setup) as robot, pytest.raises(DeviceError, match="320x240 came, expected 256x128"):
        robot.camera.read()


def test_shown_picture_is_scaled_and_upright_for_the_one_who_looks() -> None:
    setup = setup_of(rover(), "screen")
    picture = np.zeros((240, 320, 3), np.uint8)
    picture[:120, :160] = (0, 0, 255)
    with joined(scene := MemoryScene(setup), setup) as robot:
        robot.display.show(picture)
        robot.display.show(picture[..., 2])
    assert scene.shown
    shown = np.frombuffer(scene.shown.pixels, np.uint8).reshape(48, 64, 3)
    assert shown[40, 10].tolist() == [255, 255, 255]
    assert shown[10, 10].tolist() == shown[40, 50].tolist() == [0, 0, 0]


def test_joint_that_turns_backwards_is_reported_and_read_the_other_way_round() -> None:
    turned = {"path": "/rover/leftMotor", "reversed": True}
    setup = setup_of(rover(left_motor=turned, left_encoder=turned), "left_motor", "left_encoder")
    with joined(scene := MemoryScene(setup), setup) as robot:
        robot.motors["left_motor"].set_velocity(3)
        assert scene.diary[-1] == "left_motor -3"
        robot.clock.sleep_until(0.5)
        assert robot["left_encoder"].read().angle > 1  # type: ignore[attr-defined]


def test_encoder_counts_whole_turns_though_nobody_reads_it_meanwhile() -> None:
    setup = setup_of(rover())
    with joined(MemoryScene(setup), setup) as robot:
        robot.motors["right_motor"].set_velocity(10.0)
        robot.clock.sleep_until(3.0)
        assert robot["right_encoder"].read().angle == pytest.approx(30.0, abs=1.0)  # type: ignore[attr-defined]


def test_camera_on_a_pole_needs_no_wheels() -> None:
    pole = load_robot("lookout").model_copy(update={"backends": {"memory": {"eye": {"path": "/rover/eye"}}}})
    setup = Setup(pole, worlds.empty(), frozenset({"eye", "screen"}))
    scene = MemoryScene(Setup(rover(), worlds.empty(), frozenset()))
    with open_in_scene(setup, "memory", lambda: scene) as robot:
        assert isinstance(robot["eye"], Camera)
        assert robot.truth is None


def test_truth_is_the_middle_of_the_axle() -> None:
    setup = setup_of(rover())
    with joined(MemoryScene(setup), setup) as robot:
        assert robot.truth
        for motor in robot.motors.values():
            motor.set_velocity(4.0)
        robot.clock.sleep_until(1.0)
        assert robot.truth.pose().x == pytest.approx(0.13, abs=0.01)
        assert robot.truth.twist() == pytest.approx((4 * 0.0325, 0.0), abs=1e-3)
        assert robot.truth.contacts() is None


@pytest.mark.parametrize(
    "point, read", [((0.0, 0.006, 0.008), 0.02), ((0.3, 0.0, 0.4), 0.5), ((3.0, 0.0, 4.0), math.inf)]
)
def test_distance_is_the_way_to_the_point_within_the_limits(
    point: tuple[float, float, float], read: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    setup = setup_of(rover(), "nose")
    monkeypatch.setattr(MemoryScene, "detect", lambda *_: point)
    with joined(MemoryScene(setup), setup) as robot:
        assert robot.range.read().distance == pytest.approx(read)


def test_object_that_is_another_devices_was_not_meant() -> None:
    robot = rover(eye={"path": ("/v0", "v0")})
    scene = MemoryScene(setup_of(robot))
    found = {finding.what: finding.remedy for finding in inspect_scene(robot, "memory", scene)}
    assert found["eye"] == "The scene's vision sensors: /rover/eye, /v1"
    with pytest.raises(DeviceError, match=r"sensors: /rover/eye, /v1"):
        joined(scene, setup_of(robot, "eye"))


def test_looking_tells_what_is_there_and_moves_nothing() -> None:
    robot = rover(nose={"path": "/rover/nos"}, screen={"path": "/v2", "optional": True})
    scene = MemoryScene(setup_of(robot))
    scene.objects_there.append(SceneObject(30, "/lamp", ObjectKind.OTHER))
    found = {finding.what: finding for finding in inspect_scene(robot, "memory", scene)}
    assert found["left_motor"].said == "/rover/leftMotor, a joint"
    assert (found["nose"].level.value, found["nose"].remedy) == ("error", "Did you mean '/rover/nose'?")
    assert "kept in memory" in found["screen"].said
    assert scene.diary == []
