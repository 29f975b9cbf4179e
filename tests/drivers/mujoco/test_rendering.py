from __future__ import annotations

from random import Random

import numpy as np
import pytest

from drivers.mujoco.backend import MujocoBackend
from drivers.mujoco.model.attributes import CAMERA_GROUPS
from drivers.mujoco.rendering import VisibleGeoms
from drivers.mujoco.simulation import Simulation
from robotcore.description import Mount, draw_world, load_world
from robotcore.geometry import Pose
from robotcore.optics import CameraView
from tests.drivers.physics.worlds import ROVER, get_camera, setup
from tests.robotcore.simulation.painter.test_painter import LENS, create_random_view
from tests.robotcore.simulation.painter.tracer import roll


@pytest.mark.slow
def test_geoms_outside_of_the_view_are_left_out_and_the_picture_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    random = Random(5)
    world = draw_world(load_world("clutter"), ROVER, 5)
    views = [roll(create_random_view(random, world, LENS), random.uniform(-0.5, 0.5)) for _ in range(20)]
    with MujocoBackend().open(setup(world, devices=["eye"])) as robot:
        camera = get_camera(robot)
        culled = [(camera.picture(view), camera.segmentation(view)) for view in views]
    monkeypatch.setattr(VisibleGeoms, "select", lambda *_: None)
    with MujocoBackend().open(setup(world, devices=["eye"])) as robot:
        camera = get_camera(robot)
        for view, (picture, segmentation) in zip(views, culled, strict=True):
            assert np.array_equal(camera.picture(view), picture)
            assert np.array_equal(camera.segmentation(view), segmentation)


def test_most_geoms_are_outside_of_the_view_in_a_corner() -> None:
    world = draw_world(load_world("clutter"), ROVER, 5)
    simulation = Simulation(setup(world, devices=[]), world)
    groups = simulation.model.geom_group
    geoms = VisibleGeoms(simulation.model, simulation.data)
    shown = np.isin(groups, list(CAMERA_GROUPS)).sum()
    geoms.select(CameraView.of(LENS, Mount(z_m=0.1), Pose(1.7, 1.7, 0.8)))
    assert 0 < np.isin(groups, list(CAMERA_GROUPS)).sum() < shown / 2
