"""Compare the objects of scenes with the descriptions of their worlds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.description import CameraDescription, draw_world, load_robot, load_world
from robotcore.optics import CameraView
from robotcore.simulation.painter import Painter
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scene.objects import Joint, ProximitySensor, Shape, VisionSensor
from tests.doubles.coppeliasim.scene.rover import find_drives
from tests.doubles.coppeliasim.scenes import bubblerob_scene, default_scene, described_scene, relay_scene

ROVER, ARENA = load_robot("rover"), load_world("arena")


def drive_first_robot(simulator: Simulator, *speeds: float, steps: int = 20) -> None:
    """Drive the first robot of a scene with these velocities of the left and the right wheel."""
    drive = find_drives(simulator.graph)[0]
    with simulator.lock:
        simulator.start()
        drive.left.target_velocity, drive.right.target_velocity = speeds
        for _ in range(steps):
            simulator.advance()


def test_described_robot_is_at_its_start() -> None:
    world = draw_world(ARENA, ROVER, 7)
    drive = find_drives(described_scene(ROVER, world).graph)[0]
    assert drive.start == pytest.approx((world.start.x_m, world.start.y_m, world.start.yaw_rad), abs=1e-9)
    assert drive.geometry.wheel_radius == pytest.approx(0.0325)
    assert drive.geometry.track == pytest.approx(0.155)


def test_devices_are_objects_with_their_names() -> None:
    graph = described_scene(ROVER, ARENA).graph
    kinds = {"left_motor": Joint, "right_motor": Joint, "nose": ProximitySensor, "eye": VisionSensor}
    for name, kind in kinds.items():
        assert isinstance(graph.find(f"/rover/{name}"), kind)
    assert isinstance(graph.find("/screen"), VisionSensor)
    assert isinstance(graph.find("/ball"), Shape)


def test_camera_picture_equals_the_kinematic_one() -> None:
    simulator = described_scene(ROVER, ARENA)
    drive_first_robot(simulator, 0.0, 0.0, steps=1)
    eye = simulator.graph.find("/rover/eye")
    description = ROVER.first_of(CameraDescription)
    assert isinstance(eye, VisionSensor)
    assert description
    picture = Painter(ARENA).picture(CameraView.of(description.intrinsics, description.mount, ARENA.start.pose))
    off = np.abs(simulator.picture(eye)[::-1, :, ::-1].astype(int) - picture)
    assert (off > 1).mean() < 0.002


def test_robot_without_a_drive_stands_still() -> None:
    graph = described_scene(load_robot("lookout"), ARENA).graph
    assert find_drives(graph) == []
    assert isinstance(graph.find("/lookout/eye"), VisionSensor)


def test_bubblerob_has_paths_and_old_names() -> None:
    graph = bubblerob_scene().graph
    for part in ("leftMotor", "rightMotor", "sensingNose", "visionSensor"):
        found = graph.find(f"/bubbleRob/{part}")
        assert found
        assert graph.find_flat(f"bubbleRob_{part}") is found
        assert graph.path(found) == f"/bubbleRob/{part}"


def test_bubblerob_turns_about_the_middle_of_its_axle() -> None:
    simulator = bubblerob_scene()
    body = simulator.graph.find("/bubbleRob")
    assert body
    drive_first_robot(simulator, -2.5, 2.5)
    turn = 2 * 2.5 * 0.04 / 0.2
    assert simulator.graph.pose(body).yaw == pytest.approx(turn)
    x, y, z = simulator.graph.pose(body).position
    assert (x, y, z) == pytest.approx((0.05 - 0.05 * math.cos(turn), -0.05 * math.sin(turn), 0.12))


def test_relay_sees_the_ball_and_shows_a_picture() -> None:
    simulator = relay_scene()
    drive_without_a_robot(simulator)
    eye, screen = (simulator.graph.find_flat(name) for name in ("v0", "v1"))
    assert isinstance(eye, VisionSensor)
    assert isinstance(screen, VisionSensor)
    greenest = simulator.picture(eye).astype(int) @ np.array((-1, 2, -1))
    assert (greenest > 60).sum() > 500
    assert not simulator.picture(screen).any()
    simulator.show(screen, simulator.picture(eye))
    assert (simulator.picture(screen) == simulator.picture(eye)).all()


def drive_without_a_robot(simulator: Simulator) -> None:
    with simulator.lock:
        simulator.start()
        simulator.advance()


def test_next_handle_after_the_default_scene_is_15() -> None:
    simulator = default_scene()
    assert simulator.graph.add(Shape("next")).handle == 15
