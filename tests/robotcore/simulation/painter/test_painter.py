from __future__ import annotations

import math
from itertools import pairwise, product
from random import Random

import numpy as np
import pytest

from robotcore.description import Ball, Box, Cylinder, Light, Mount, Walls, WorldDescription
from robotcore.description.generation.gaps import compute_gap
from robotcore.geometry import Pose
from robotcore.optics import CameraView, Intrinsics
from robotcore.simulation.painter import Painter
from robotcore.simulation.painter.occlusion import sort_back_to_front
from robotcore.simulation.painter.rasterizing import rasterize
from tests.drivers.kinematic.rooms import ball, box, post, room
from tests.robotcore.simulation.painter.tracer import compute_rays, roll, trace_depths, trace_labels

LENS = Intrinsics(160, 120, 1.0821)
ORIGIN = Pose(0.0, 0.0, 0.0)


def view(pose: Pose = ORIGIN, z: float = 0.1, pitch: float = 0.0) -> CameraView:
    return CameraView.of(LENS, Mount(z_m=z, pitch_rad=pitch), pose)


def create_random_world(random: Random) -> WorldDescription:
    """Return a world with random obstacles, which may overlap one another and the walls."""
    obstacles: list[Box | Cylinder] = []
    for number in range(random.randrange(9)):
        x, y, height = random.uniform(-1.9, 1.9), random.uniform(-1.9, 1.9), random.choice((0.2, 0.3, 0.45))
        if random.random() < 0.6:
            length, width, yaw = random.uniform(0.1, 1.6), random.uniform(0.05, 0.6), random.uniform(-3, 3)
            obstacles.append(box(x, y, length, width, height=height, yaw=yaw, name=f"box-{number}"))
        else:
            obstacles.append(post(x, y, random.uniform(0.05, 0.35), height, name=f"post-{number}"))
    balls: list[Ball] = []
    for number in range(3):
        drawn = ball(random.uniform(-1.7, 1.7), random.uniform(-1.7, 1.7), random.uniform(0.05, 0.2), f"ball-{number}")
        if all(compute_gap(drawn.outline, other.outline) > 0.004 for other in (*obstacles, *balls)):
            balls.append(drawn)
    return room(*obstacles, *balls, walls=Walls(height_m=0.35) if random.random() < 0.7 else None)


def create_random_view(random: Random, world: WorldDescription, lens: Intrinsics = LENS) -> CameraView:
    """Return a random view whose camera is outside all bodies."""
    while True:
        x, y = random.uniform(-1.95, 1.95), random.uniform(-1.95, 1.95)
        around = ((x + 0.005, y), (x, y + 0.005), (x - 0.005, y), (x, y - 0.005))
        if all(compute_gap(around, thing.outline) > 0 for thing in (*world.prisms, *world.targets)):
            pose = Pose(x, y, random.uniform(-math.pi, math.pi))
            z, pitch = random.choice((0.1, 0.48, 0.9)), random.choice((0.0, 0.2, -0.3, 0.8))
            return CameraView.of(lens, Mount(z_m=z, pitch_rad=pitch), pose)


@pytest.mark.slow
def test_label_of_each_pixel_is_the_first_body_on_its_ray() -> None:
    for seed in range(20):
        random = Random(seed)
        world = create_random_world(random)
        painter = Painter(world)
        for _ in range(5):
            seen = create_random_view(random, world)
            assert np.array_equal(painter.labels(seen), trace_labels(world, seen)), seed


@pytest.mark.parametrize("angle", [-0.7, 0.002, 0.05, 1.6, 3.0])
def test_labels_and_sky_are_correct_for_a_camera_that_rolls(angle: float) -> None:
    random = Random(3)
    world = create_random_world(random)
    painter = Painter(world)
    for _ in range(5):
        seen = roll(create_random_view(random, world), angle)
        labels = trace_labels(world, seen)
        assert np.array_equal(painter.labels(seen), labels)
        is_sky = (painter.picture(seen) == world.light.sky_colour[::-1]).all(axis=2)
        assert np.array_equal(is_sky, (labels == 0) & (compute_rays(seen)[..., 2] >= 0))


def create_random_screens(random: Random) -> WorldDescription:
    """Return a world with random thin boxes that do not overlap."""
    screens: list[Box] = []
    for number in range(40):
        x, y, length, yaw = (
            random.uniform(-1.9, 1.9),
            random.uniform(-1.9, 1.9),
            random.uniform(0.3, 1.8),
            random.uniform(-3, 3),
        )
        screen = box(x, y, length, 0.05, yaw=yaw, name=f"screen-{number}")
        if all(compute_gap(screen.outline, other.outline) > 0 for other in screens):
            screens.append(screen)
    return room(*screens)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [14, 36, 47])
def test_labels_are_correct_for_a_wide_lens_among_many_screens(seed: int) -> None:
    random = Random(seed)
    world = create_random_screens(random)
    painter = Painter(world)
    for _ in range(8):
        seen = create_random_view(random, world, Intrinsics(160, 120, 2.6))
        assert np.array_equal(painter.labels(seen), trace_labels(world, seen))


def test_ball_beside_the_camera_has_correct_labels() -> None:
    for place in [(-0.09, -0.11), (-0.09, 0.11), (-0.01, 0.13), (0.05, 0.12)]:
        world = room(ball(*place))
        assert np.array_equal(Painter(world).labels(view()), trace_labels(world, view())), place


def test_wall_close_to_the_camera_hides_all_other_bodies() -> None:
    painter = Painter(room(box(1.5, 0.0, 1.0, 3.0, height=2.0), walls=Walls(height_m=3.0)))
    for gap, heading in product([1e-2, 1e-4, 1e-6], [0.0, 0.4, -0.4]):
        assert set(np.unique(painter.labels(view(Pose(1.0 - gap, 0.0, heading))))) == {5}, (gap, heading)


def test_ball_close_to_the_camera_fills_the_picture() -> None:
    painter = Painter(room(ball(0.5, 0.0), walls=Walls(height_m=0.3)))
    assert set(np.unique(painter.labels(view(Pose(0.399, 0.0, 0.0))))) == {5}


def test_long_wall_with_a_nearer_centre_does_not_hide_a_ball_in_front_of_its_end() -> None:
    world = room(box(0.8, 0.4, 3.6, 0.05, yaw=0.12, height=0.4), ball(2.2, 0.3, 0.1))
    for heading in np.linspace(-0.5, 0.5, 11).tolist():
        seen = view(Pose(0.0, 0.0, heading))
        assert np.array_equal(Painter(world).labels(seen), trace_labels(world, seen)), heading


def test_top_of_a_box_is_visible_only_from_above() -> None:
    world = room(box(1.0, 0.0, 0.4, 0.4, height=0.3))
    low, high = (Painter(world).picture(view(z=z, pitch=0.3)) for z in (0.2, 0.6))
    reds = [set(image[image[..., 2] > image[..., 0].astype(int) + 40][:, 2].tolist()) for image in (low, high)]
    assert (len(reds[0]), len(reds[1])) == (1, 2)


@pytest.mark.parametrize("pitch", [-0.3, 0.0, 0.2])
def test_horizon_is_in_the_row_of_the_pitch(pitch: float) -> None:
    world = room()
    image = Painter(world).picture(view(pitch=pitch))
    is_sky = (image == np.array(world.light.sky_colour[::-1])).all(axis=2)
    horizon = LENS.cy - LENS.focal_length * math.tan(pitch)
    assert is_sky.sum(axis=0).tolist() == [math.floor(horizon) + 1] * LENS.width


def test_brightness_of_a_face_depends_on_its_angle_to_the_lamp() -> None:
    light = Light(azimuth_rad=math.pi, elevation_rad=math.pi / 4, ambient=0.5, diffuse=0.4, brightness=0.9)
    world = room(box(1.0, 0.0, 0.2, 3.0, height=2.0)).model_copy(update={"light": light})
    red, green, blue = world.obstacles[0].colour
    shade = (0.5 + 0.4 * math.cos(math.pi / 4)) * 0.9
    expected = [round(part * shade) for part in (blue, green, red)]
    assert Painter(world).picture(view())[60, 80].tolist() == expected


def test_brightness_of_a_ball_depends_on_its_angle_to_the_lamp() -> None:
    light = Light(azimuth_rad=2.5, elevation_rad=0.4, ambient=0.3, diffuse=0.7)
    world = room(ball(0.6, 0.05)).model_copy(update={"light": light})
    seen, target = view(), world.targets[0]
    is_ball = trace_labels(world, seen) == 1
    surface = seen.eye + (trace_depths(world, seen)[1][..., None] * compute_rays(seen))[is_ball]
    normals = (surface - (target.x_m, target.y_m, target.radius_m)) / target.radius_m
    shade = light.ambient + light.diffuse * np.maximum(normals @ light.direction, 0)
    expected = np.array(target.colour[::-1]) * shade[:, None]
    assert np.ptp(shade) > 0.5
    assert np.abs(Painter(world).picture(seen)[is_ball] - expected).max() < 1


def test_parts_that_hide_one_another_in_a_cycle_are_sorted_without_an_error() -> None:
    assert sorted(sort_back_to_front({0: [1], 1: [2], 2: [0]})) == [0, 1, 2]


def test_neighbouring_polygons_leave_no_gap() -> None:
    canvas = np.zeros((40, 60), dtype=np.uint32)
    edges = [10 + 0.37 * i for i in range(60)]
    for left, right in pairwise(edges):
        rasterize([left, right, right - 20, left - 20], [5.0, 5.0, 35.0, 35.0], 60, 40).fill(canvas, 1)
    assert all(len(np.unique(np.diff(np.flatnonzero(row)))) <= 1 for row in canvas)
    assert canvas[20].any()
