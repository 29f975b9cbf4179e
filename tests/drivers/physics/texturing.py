from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.description import Light, Start, Texture, WorldDescription, draw_world, load_world, randomise
from robotcore.description.texture import PATTERNS, Pattern
from robotcore.geometry import Pose
from robotcore.optics import View
from robotcore.simulation.painter import Painter
from tests.drivers.physics.seeing import EYE
from tests.drivers.physics.worlds import ROVER, OnAnEngine, ball, box, eye, post, world

MIN_PIXELS = 150
HERE = Pose(0.0, 0.0, 0.0)

Mask = np.ndarray


class Texturing(OnAnEngine):
    """How textures show: the same on every engine, and as in the built-in simulator."""

    @pytest.mark.parametrize("pattern", PATTERNS)
    def test_the_built_in_simulator_shows_the_same_pattern_at_every_pixel(self, pattern: Pattern) -> None:
        texture = Texture(pattern=pattern, scale_m=0.8, contrast=0.5)
        plain = box(1.2, 0.5, width=0.4, yaw=0.4), post(0.9, -0.2)
        things = [thing.model_copy(update={"texture": texture}) for thing in plain]
        ground = world(*things, ball(0.8, 0.15))
        ground = ground.model_copy(update={"floor": ground.floor.model_copy(update={"texture": texture})})
        ours, theirs, _ = self.pictures(ground, HERE)
        is_near = np.arange(240) > 140
        differences = np.abs(ours.astype(int) - theirs).max(axis=2)
        assert (differences[is_near] <= 2).mean() > 0.98
        assert (differences <= 2).mean() > 0.9

    def test_a_texture_darkens_as_in_the_built_in_simulator_what_the_light_makes_brighter_than_white(self) -> None:
        texture = Texture(pattern="planks", scale_m=0.3, contrast=0.5)
        wall = box(1.2, width=3.0, height=1.0).model_copy(update={"texture": texture, "colour": (250, 240, 230)})
        facing = Light(azimuth_rad=math.pi, elevation_rad=0.3, brightness=1.4)
        ours, theirs, masks = self.pictures(world(wall, light=facing), HERE)
        mine, other = masks["box"]
        assert ours[mine].mean(axis=0) == pytest.approx(theirs[other].mean(axis=0), abs=2.0)

    @pytest.mark.parametrize("name, seed", [("arena", 1), ("arena", 9), ("clutter", 4), ("open", 10), ("occluded", 11)])
    def test_of_a_randomised_world_both_simulators_show_every_thing_in_the_same_colour(
        self, name: str, seed: int
    ) -> None:
        drawn = randomise(draw_world(load_world(name), ROVER, seed), seed).world
        ours, theirs, masks = self.pictures(drawn, drawn.start.pose)
        assert masks
        for thing, (mine, other) in masks.items():
            assert ours[mine].mean(axis=0) == pytest.approx(theirs[other].mean(axis=0), abs=3.0), thing

    def pictures(
        self, described: WorldDescription, pose: Pose
    ) -> tuple[np.ndarray, np.ndarray, dict[str, tuple[Mask, Mask]]]:
        """Return what the painter and the engine show, and by name where each shows what both show enough of."""
        painter = Painter(described)
        start = Start(x_m=pose.x, y_m=pose.y, yaw_rad=pose.heading)
        with self.opened_in(described.model_copy(update={"start": start})) as robot:
            camera = eye(robot)
            view = View.of(camera.intrinsics, EYE, pose)
            theirs, numbers, labels = camera.picture(view), camera.numbers(view), painter.labels(view)
        masks = {thing: (labels == n, numbers == camera.things[thing]) for n, thing in enumerate(painter.things, 1)}
        is_below = np.arange(len(labels))[:, None] >= 121
        masks["floor"] = ((labels == 0) & is_below, ~np.isin(numbers, list(camera.things.values())) & is_below)
        return painter.picture(view), theirs, {n: m for n, m in masks.items() if min(x.sum() for x in m) > MIN_PIXELS}
