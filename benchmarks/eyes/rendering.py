"""Two renderers of a scene: the painted camera of the kinematic backend, and PyBullet's."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.eyes.scenes import Scene
from drivers.pybullet.sensors import BulletCamera
from robotcore.description import load_robot
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.devices import Image
from robotcore.simulation.painter import Painter

Mask = NDArray[np.bool_]


class Rendering(NamedTuple):
    """A picture, (height, width, 3), BGR, and the masks of the ball and the floor, (height, width)."""

    image: Image
    ball: Mask
    floor: Mask


def render_with_painter(scene: Scene) -> Rendering:
    """Render a scene with the painted camera of the kinematic backend."""
    painter = Painter(scene.world)
    image, labels = painter.picture(scene.view), painter.labels(scene.view)
    is_sky = (image == scene.world.light.sky_colour[::-1]).all(axis=2)
    ball = labels == painter.things.index("ball") + 1 if scene.world.targets else np.zeros(labels.shape, bool)
    return Rendering(image, ball, (labels == 0) & ~is_sky)


def render_with_bullet(scene: Scene) -> Rendering:
    """Render a scene with PyBullet's software renderer."""
    with load_backend("pybullet").open(Setup(load_robot("rover"), scene.world, frozenset({"eye"}))) as opened:
        camera = opened.camera
        assert isinstance(camera, BulletCamera)
        image, numbers = camera.picture(scene.view), camera.segmentation(scene.view)
        things = list(camera.things.values())
        ball = numbers == camera.things.get("ball", len(things) + 99)
        return Rendering(image, ball, (numbers >= 0) & ~np.isin(numbers, things))
