"""Domain randomisation: draws light, colours, textures, and errors of sensors and wheels from a seed."""

from __future__ import annotations

import colorsys
from collections.abc import Iterable, Sequence
from itertools import pairwise
from random import Random
from typing import NamedTuple, TypeVar

from robotcore.description.conditions import Conditions, Light
from robotcore.description.texture import Texture
from robotcore.description.types import Rgb, hue_degrees
from robotcore.description.world import Ball, Box, Cylinder, Floor, Walls, WorldDescription
from robotcore.errors import DescriptionError

Arc = tuple[float, float]
"""A range of hues on the colour circle: the first hue, and the length of the range, in degrees."""


def free_arcs(taken: Iterable[float], gap: float) -> list[Arc]:
    """Return the ranges of hues that differ from all taken hues by at least ``gap``, in degrees.

    >>> free_arcs([0.0, 180.0], gap=60.0)
    [(60.0, 60.0), (240.0, 60.0)]
    """
    hues = sorted(hue % 360 for hue in taken)
    if not hues:
        return [(0.0, 360.0)]
    neighbours = pairwise([*hues, hues[0] + 360])
    return [(low + gap, high - low - 2 * gap) for low, high in neighbours if high - low > 2 * gap]


def hue_at(arcs: Sequence[Arc], share: float) -> float:
    """Return the hue at a fraction of the total length of all arcs, in degrees. It may be above 360.

    share: the fraction, from 0 to 1.
    """
    along = share * sum(length for _, length in arcs)
    for start, length in arcs:
        if along <= length:
            return start + along
        along -= length
    start, length = arcs[-1]
    return start + length


DrawnValues = dict[str, float | str]
Limits = tuple[float, float]
SurfaceT = TypeVar("SurfaceT", Floor, Walls)


class RandomisedWorld(NamedTuple):
    """A randomised world, and the values that were drawn for it."""

    world: WorldDescription
    values: DrawnValues
    """The drawn values by name, for reports."""


def randomise(world: WorldDescription, seed: int) -> RandomisedWorld:
    """Return a world with light, colours, textures and errors drawn from a seed. The layout does not change.

    Raises DescriptionError if no hue differs enough from the hues of the targets.

    >>> from robotcore.description import load_world
    >>> randomise(load_world("arena"), seed=7).values["camera_noise"]
    3.1636
    """
    drawing = _Randomiser(world, seed)
    return RandomisedWorld(drawing.draw(), drawing.drawn)


class _Randomiser:
    """Draws the values for a seed.

    The random stream of each quantity is seeded by the seed and the name of the quantity. So a new quantity does not
    change the values of the others. `Random` hashes a text seed by SHA-512, so that the values are equal on all
    machines and Python versions.
    """

    def __init__(self, world: WorldDescription, seed: int) -> None:
        self.drawn: DrawnValues = {}
        self._world, self._seed, self._ranges = world, seed, world.randomisation
        self._hues = _find_free_hues(world, map(self._draw_target_hue, world.targets))

    def draw(self) -> WorldDescription:
        world = self._world
        parts = {
            "light": self._draw_light(world.light),
            "floor": self._draw_surface("floor", world.floor),
            "walls": world.walls and self._draw_surface("walls", world.walls),
            "obstacles": self._draw_obstacles(world.obstacles),
            "targets": tuple(self._draw_target(ball) for ball in world.targets),
            "conditions": self._draw_conditions(world.conditions),
        }
        return world.model_copy(update=parts)

    def _draw_light(self, light: Light) -> Light:
        brightness = self._draw_number("light_brightness", self._ranges.light_brightness, light.brightness)
        ambient = self._draw_number("light_ambient", self._ranges.light_ambient, light.ambient)
        diffuse = light.diffuse if self._ranges.light_ambient is None else 1 - ambient
        sky = self._note_colour("sky", self._draw_colour("sky", light.sky_colour))
        return light.model_copy(
            update={"brightness": brightness, "ambient": ambient, "diffuse": diffuse, "sky_colour": sky}
        )

    def _draw_surface(self, name: str, surface: SurfaceT) -> SurfaceT:
        colour = self._note_colour(name, self._draw_colour(name, surface.colour))
        return surface.model_copy(update={"colour": colour, "texture": self._draw_texture(name, surface.texture)})

    def _draw_obstacles(self, obstacles: tuple[Box | Cylinder, ...]) -> tuple[Box | Cylinder, ...]:
        # Each obstacle has its own colour, but all have the same pattern.
        return tuple(
            obstacle.model_copy(
                update={
                    "colour": self._draw_colour(f"obstacle {obstacle.name}", obstacle.colour),
                    "texture": self._draw_texture("obstacles", obstacle.texture),
                }
            )
            for obstacle in obstacles
        )

    def _draw_target(self, ball: Ball) -> Ball:
        ranges, (_, saturation, value) = self._ranges, _to_hsv(ball.colour)
        saturation *= self._draw(f"target {ball.name} saturation", ranges.target_saturation, 1.0)
        value *= self._draw(f"target {ball.name} value", ranges.target_value, 1.0)
        colour = _to_rgb(self._draw_target_hue(ball), saturation, value)
        if ball == self._world.target:
            self._note_colour("target", colour)
        return ball.model_copy(update={"colour": colour})

    def _draw_target_hue(self, ball: Ball) -> float:
        turn = self._draw(f"target {ball.name} hue", self._ranges.target_hue_deg, 0.0)
        return hue_degrees(ball.colour) + turn

    def _draw_conditions(self, conditions: Conditions) -> Conditions:
        drawn = {}
        for name in type(conditions).model_fields:
            key = "wheel_gain" if name.startswith("wheel_gain") else name
            drawn[name] = self._draw_number(name, getattr(self._ranges, key), getattr(conditions, name))
        return conditions.model_copy(update=drawn)

    def _draw_colour(self, name: str, written: Rgb) -> Rgb:
        hue, saturation, value = _to_hsv(written)
        if self._hues:
            hue = hue_at(self._hues, self._share(f"{name} hue"))
        saturation = self._draw(f"{name} saturation", self._ranges.colour_saturation, saturation)
        return _to_rgb(hue, saturation, self._draw(f"{name} value", self._ranges.colour_value, value))

    def _draw_texture(self, name: str, written: Texture | None) -> Texture | None:
        ranges = self._ranges
        if ranges.patterns is None:
            return written
        old = written or Texture(pattern="plain")
        pattern = ranges.patterns[int(len(ranges.patterns) * self._share(f"{name}_pattern"))]
        self.drawn[f"{name}_pattern"] = pattern
        scale = self._draw_number(f"{name}_pattern_scale_m", ranges.pattern_scale_m, old.scale_m)
        contrast = self._draw_number(f"{name}_pattern_contrast", ranges.pattern_contrast, old.contrast)
        return None if pattern == "plain" else Texture(pattern=pattern, scale_m=scale, contrast=contrast)

    def _note_colour(self, name: str, colour: Rgb) -> Rgb:
        parts = zip(("hue_deg", "saturation", "value"), _to_hsv(colour), strict=True)
        self.drawn |= {f"{name}_{part}": round(value, 4) for part, value in parts}
        return colour

    def _draw_number(self, name: str, limits: Limits | None, written: float) -> float:
        """Return a number drawn within the limits, and add it to `drawn`.

        written: the value in the world's file, which is returned if ``limits`` is None.
        """
        number = self._draw(name, limits, written)
        if limits is not None:
            self.drawn[name] = number
        return number

    def _draw(self, name: str, limits: Limits | None, written: float) -> float:
        if limits is None:
            return written
        low, high = limits
        # Rounded, so that reports show the exact value.
        return round(low + (high - low) * self._share(name), 4)

    def _share(self, name: str) -> float:
        return Random(f"{self._seed}:{name}").random()


def _find_free_hues(world: WorldDescription, taken: Iterable[float]) -> list[Arc]:
    gap = world.randomisation.hue_gap_deg
    if gap is None:
        return []
    free = free_arcs(taken, gap)
    if not free:
        key, problem = "randomisation.hue_gap_deg", f"is {gap:g}, so no hue differs enough from those of the targets"
        raise DescriptionError(f"the world {world.name!r}", key, problem, "Reduce it", kind="no-free-hue")
    return free


def _to_hsv(colour: Rgb) -> tuple[float, float, float]:
    """Return the hue of a colour in degrees, and its HSV saturation and value, both from 0 to 1."""
    red, green, blue = (part / 255 for part in colour)
    hue, saturation, value = colorsys.rgb_to_hsv(red, green, blue)
    return 360 * hue, saturation, value


def _to_rgb(hue: float, saturation: float, value: float) -> Rgb:
    red, green, blue = colorsys.hsv_to_rgb(hue / 360 % 1, min(saturation, 1.0), min(value, 1.0))
    return round(255 * red), round(255 * green), round(255 * blue)


def describe_light(light: Light) -> DrawnValues:
    """Return the values of the light that `draw_world` draws from a seed, by name, for reports."""
    return {f"light_{name}": getattr(light, name) for name in ("azimuth_rad", "elevation_rad", "brightness")}


def describe_conditions(conditions: Conditions) -> DrawnValues:
    """Return the values of the conditions that differ from their defaults, by name, for reports."""
    values: DrawnValues = conditions.model_dump(exclude_defaults=True)
    return values


def describe_picture(drawn: DrawnValues) -> DrawnValues:
    """Return ``picture_brightness``, the product of the drawn light brightness and the drawn camera exposure.

    The result is empty if one of the two was not drawn. Reports about the causes of failed runs need the product,
    because a dim lamp and a short exposure both make pictures dark.
    """
    light, exposure = drawn.get("light_brightness"), drawn.get("camera_exposure")
    if isinstance(light, float) and isinstance(exposure, float):
        return {"picture_brightness": round(light * exposure, 4)}
    return {}
