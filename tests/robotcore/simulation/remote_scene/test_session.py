from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from robotcore.description import RobotDescription, load_robot
from robotcore.errors import BackendError, DeviceError, DeviceGroupError, UsageError
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.kinds.bumper import BumperDescription
from robotcore.kinds.camera import Camera
from robotcore.kinds.display import MemoryDisplay
from robotcore.simulation.remote_scene import (
    CameraOptics,
    ObjectKind,
    SceneObject,
    SimulationControl,
    State,
    inspect_scene,
    open_in_scene,
)
from robotcore.testing import worlds
from tests.robotcore.simulation.remote_scene.memory import MemoryScene, rover
from tests.texts import CheckText, Raises

Change = Callable[[MemoryScene], object]


def create_setup(robot: RobotDescription, *devices: str, rate_hz: float = 20.0) -> Setup:
    names = devices or tuple(device.name for device in robot.devices)
    return Setup(robot, worlds.empty(), frozenset(names), rate_hz)


def open_robot(scene: MemoryScene, setup: Setup, control: SimulationControl = SimulationControl.PROGRAM) -> Robot:
    return open_in_scene(setup, "memory", lambda: scene, control)


def create_scene(setup: Setup, change: Change, state: State = State.STOPPED) -> MemoryScene:
    scene = MemoryScene(setup, state)
    change(scene)
    return scene


def remove(path: str, scene: MemoryScene) -> None:
    scene.present_objects = [each for each in scene.present_objects if each.path != path]


def test_stopped_simulation_is_started_and_stopped_after_the_motors() -> None:
    setup = create_setup(rover())
    with open_robot(scene := MemoryScene(setup), setup) as robot:
        assert scene.diary == ["start", "left_motor 0", "right_motor 0"]
        robot.motors["left_motor"].set_velocity(2.0)
        scene.diary.clear()
    assert scene.diary[:2] == ["left_motor 0", "right_motor 0"]
    assert scene.diary[-2:] == ["stop", "leave"]


def test_running_simulation_is_left_running() -> None:
    setup = create_setup(rover())
    with open_robot(scene := MemoryScene(setup, State.RUNNING), setup):
        pass
    assert "stop" not in scene.diary
    assert scene.diary[-1] == "leave"


@pytest.mark.parametrize(
    "state, control, kind",
    [
        (State.PAUSED, SimulationControl.PROGRAM, "simulation-paused"),
        (State.STOPPED, SimulationControl.USER, "simulation-stopped"),
    ],
)
def test_simulation_that_must_not_be_started_is_refused_and_unchanged(
    state: State, control: SimulationControl, kind: str, raises: Raises
) -> None:
    setup = create_setup(rover())
    scene = MemoryScene(setup, state)
    with raises(BackendError, kind):
        open_robot(scene, setup, control)
    assert scene.diary == ["leave"]


def test_device_of_a_kind_that_no_scene_has_is_refused_before_the_connection(raises: Raises) -> None:
    robot = rover()
    bumper = BumperDescription(kind="bumper", name="front")
    setup = create_setup(robot.model_copy(update={"devices": (*robot.devices, bumper)}))
    with raises(DeviceError, "not-in-scene", device="front"):
        open_in_scene(setup, "memory", lambda: pytest.fail("it connected"))


def test_one_error_names_all_unusable_objects_with_suggestions(raises: Raises) -> None:
    setup = create_setup(rover(nose={"path": "/rover/nos"}, eye={"path": "/rover/leftMotor"}))
    scene = MemoryScene(setup)
    with raises(DeviceGroupError) as caught:
        open_robot(scene, setup)
    kinds = {failure.device: failure.kind for failure in caught.value.failures if isinstance(failure, DeviceError)}
    assert kinds == {"nose": "missing-object", "eye": "wrong-object"}
    assert scene.diary == ["leave"]


@pytest.mark.parametrize(
    "change, device, kind",
    [
        pytest.param(partial(remove, "/v1"), "screen", "missing-object", id="missing"),
        pytest.param(
            lambda scene: setattr(scene, "eye", CameraOptics(256, 256, 1.0821)), "eye", "different-optics", id="size"
        ),
        pytest.param(
            lambda scene: setattr(scene, "eye", CameraOptics(320, 240, 0.5)), "eye", "different-optics", id="fov"
        ),
        pytest.param(
            lambda scene: setattr(scene, "defect", "no plug-in. Install it"),
            "nose",
            "sensor-not-simulated",
            id="sensor",
        ),
    ],
)
def test_unusable_object_is_refused_before_the_start(change: Change, device: str, kind: str, raises: Raises) -> None:
    setup = create_setup(rover())
    scene = create_scene(setup, change)
    with raises(DeviceError, kind, device=device):
        open_robot(scene, setup)
    assert "start" not in scene.diary


def test_two_motors_on_one_joint_are_refused(raises: Raises) -> None:
    setup = create_setup(rover(right_motor={"path": "/rover/leftMotor"}), "left_motor", "right_motor")
    with raises(DeviceError, "shared-joint", device="right_motor", path="/rover/leftMotor", other="left_motor"):
        open_robot(MemoryScene(setup), setup)


def test_rate_that_does_not_fit_the_time_step_is_refused_before_the_start(raises: Raises) -> None:
    setup = create_setup(rover(), rate_hz=30.0)
    scene = MemoryScene(setup)
    with raises(UsageError, "rate-does-not-fit"):
        open_robot(scene, setup)
    assert scene.diary == ["leave"]


def test_optional_display_without_an_object_keeps_pictures_in_memory() -> None:
    setup = create_setup(rover(screen={"path": "/v1", "optional": True}))
    with open_robot(create_scene(setup, partial(remove, "/v1")), setup) as robot:
        assert isinstance(robot.display, MemoryDisplay)


def test_camera_as_found_has_the_scenes_intrinsics_and_refuses_pictures_of_another_size(raises: Raises) -> None:
    setup = create_setup(rover(eye={"path": "/rover/eye", "as_found": True}), "eye")
    scene = create_scene(setup, lambda scene: setattr(scene, "eye", CameraOptics(256, 128, 1.0)))
    with open_robot(scene, setup) as robot:
        intrinsics = robot.camera.intrinsics
        assert (intrinsics.width, intrinsics.height, intrinsics.horizontal_fov) == (256, 128, 1.0)
        with raises(DeviceError, "picture-size", width=320, height=240):
            robot.camera.read()


def test_shown_picture_is_scaled_and_upright() -> None:
    setup = create_setup(rover(), "screen")
    picture = np.zeros((240, 320, 3), np.uint8)
    picture[:120, :160] = (0, 0, 255)
    with open_robot(scene := MemoryScene(setup), setup) as robot:
        robot.display.show(picture)
        robot.display.show(picture[..., 2])
    assert scene.shown
    shown = np.frombuffer(scene.shown.pixels, np.uint8).reshape(48, 64, 3)
    assert shown[40, 10].tolist() == [255, 255, 255]
    assert shown[10, 10].tolist() == shown[40, 50].tolist() == [0, 0, 0]


def test_reversed_joint_is_commanded_and_read_with_the_opposite_sign() -> None:
    reversed_joint = {"path": "/rover/leftMotor", "reversed": True}
    setup = create_setup(rover(left_motor=reversed_joint, left_encoder=reversed_joint), "left_motor", "left_encoder")
    with open_robot(scene := MemoryScene(setup), setup) as robot:
        robot.motors["left_motor"].set_velocity(3)
        assert scene.diary[-1] == "left_motor -3"
        robot.clock.sleep_until(0.5)
        assert robot["left_encoder"].read().angle > 1  # type: ignore[attr-defined]


def test_encoder_counts_whole_turns_between_two_reads() -> None:
    setup = create_setup(rover())
    with open_robot(MemoryScene(setup), setup) as robot:
        robot.motors["right_motor"].set_velocity(10.0)
        robot.clock.sleep_until(3.0)
        assert robot["right_encoder"].read().angle == pytest.approx(30.0, abs=1.0)  # type: ignore[attr-defined]


def test_robot_without_wheels_has_no_truth() -> None:
    pole = load_robot("lookout").model_copy(update={"backends": {"memory": {"eye": {"path": "/rover/eye"}}}})
    setup = Setup(pole, worlds.empty(), frozenset({"eye", "screen"}))
    scene = MemoryScene(Setup(rover(), worlds.empty(), frozenset()))
    with open_in_scene(setup, "memory", lambda: scene) as robot:
        assert isinstance(robot["eye"], Camera)
        assert robot.truth is None


def test_truth_is_the_middle_of_the_axle() -> None:
    setup = create_setup(rover())
    with open_robot(MemoryScene(setup), setup) as robot:
        assert robot.truth
        for motor in robot.motors.values():
            motor.set_velocity(4.0)
        robot.clock.sleep_until(1.0)
        assert robot.truth.pose().x == pytest.approx(0.13, abs=0.01)
        assert robot.truth.twist() == pytest.approx((4 * 0.0325, 0.0), abs=1e-3)
        assert robot.truth.contacts() is None


@pytest.mark.parametrize(
    "point, distance", [((0.0, 0.006, 0.008), 0.02), ((0.3, 0.0, 0.4), 0.5), ((3.0, 0.0, 4.0), math.inf)]
)
def test_distance_is_the_norm_of_the_point_within_the_limits(
    point: tuple[float, float, float], distance: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    setup = create_setup(rover(), "nose")
    monkeypatch.setattr(MemoryScene, "detect", lambda *_: point)
    with open_robot(MemoryScene(setup), setup) as robot:
        assert robot.range.read().distance == pytest.approx(distance)


def test_suggestions_omit_objects_of_other_devices(raises: Raises) -> None:
    robot = rover(eye={"path": ("/v0", "v0")})
    scene = MemoryScene(create_setup(robot))
    with raises(DeviceError, "missing-object"):
        open_robot(scene, create_setup(robot, "eye"))


def test_inspection_finds_objects_and_moves_nothing(check_text: CheckText) -> None:
    robot = rover(nose={"path": "/rover/nos"}, screen={"path": "/v2", "optional": True})
    scene = MemoryScene(create_setup(robot))
    scene.present_objects.append(SceneObject(30, "/lamp", ObjectKind.OTHER))
    found = {finding.subject: finding for finding in inspect_scene(robot, "memory", scene)}
    assert {name: finding.kind for name, finding in found.items()} == {
        "left_motor": "object-found",
        "right_motor": "object-found",
        "left_encoder": "object-found",
        "right_encoder": "object-found",
        "nose": "missing-object",
        "eye": "object-found",
        "screen": "kept-in-memory",
    }
    assert found["nose"].level.value == "error"
    check_text("\n".join(f"{name}: {finding.message}. {finding.remedy}" for name, finding in found.items()))
    assert scene.diary == []
