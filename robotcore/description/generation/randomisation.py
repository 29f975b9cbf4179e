"""Domain randomisation: light, colours, textures, sensors and wheels drawn from a seed."""

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
"""Where a range of hues starts on the colour circle, and its length, in degrees."""


def free_arcs(taken: Iterable[float], gap: float) -> list[Arc]:
    """Return the ranges of hues that are more than ``gap`` degrees away from each that is taken."""
    hues = sorted(hue % 360 for hue in taken)
    if not hues:
        return [(0.0, 360.0)]
    neighbours = pairwise([*hues, hues[0] + 360])
    return [(low + gap, high - low - 2 * gap) for low, high in neighbours if high - low > 2 * gap]


def hue_at(arcs: Sequence[Arc], share: float) -> float:
    """Return the hue at a share, 0 to 1, of the way through all the arcs; it may lie beyond 360."""
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


class Randomised(NamedTuple):
    """A world, and by name what was drawn for it."""

    world: WorldDescription
    values: DrawnValues


def randomise(world: WorldDescription, seed: int) -> Randomised:
    """Return a world in the conditions of a seed; what stands where does not change.

    Raises DescriptionError where the targets leave no hue to the rest.
    """
    drawing = _Randomiser(world, seed)
    return Randomised(drawing.world(), drawing.drawn)


class _Randomiser:
    """The draws of one seed.

    Each quantity has a stream of its own, seeded by its name, so that a new one changes no other. `Random` takes a
    string in by SHA-512, the same on every version and machine.
    """

    def __init__(self, world: WorldDescription, seed: int) -> None:
        self.drawn: DrawnValues = {}
        self._world, self._seed, self._ranges = world, seed, world.randomisation
        self._hues = _free_hues(world, map(self._target_hue, world.targets))

    def world(self) -> WorldDescription:
        world = self._world
        parts = {
            "light": self._light(world.light),
            "floor": self._surface("floor", world.floor),
            "walls": world.walls and self._surface("walls", world.walls),
            "obstacles": self._obstacles(world.obstacles),
            "targets": tuple(self._target(ball) for ball in world.targets),
            "conditions": self._conditions(world.conditions),
        }
        return world.model_copy(update=parts)

    def _light(self, light: Light) -> Light:
        brightness = self._number("light_brightness", self._ranges.light_brightness, light.brightness)
        ambient = self._number("light_ambient", self._ranges.light_ambient, light.ambient)
        diffuse = light.diffuse if self._ranges.light_ambient is None else 1 - ambient
        sky = self._note_colour("sky", self._colour("sky", light.sky_colour))
        return light.model_copy(
            update={"brightness": brightness, "ambient": ambient, "diffuse": diffuse, "sky_colour": sky}
        )

    def _surface(self, name: str, surface: SurfaceT) -> SurfaceT:
        colour = self._note_colour(name, self._colour(name, surface.colour))
        return surface.model_copy(update={"colour": colour, "texture": self._texture(name, surface.texture)})

    def _obstacles(self, obstacles: tuple[Box | Cylinder, ...]) -> tuple[Box | Cylinder, ...]:
        """Return each in a colour of its own, all in one pattern."""
        return tuple(
            obstacle.model_copy(
                update={
                    "colour": self._colour(f"obstacle {obstacle.name}", obstacle.colour),
                    "texture": self._texture("obstacles", obstacle.texture),
                }
            )
            for obstacle in obstacles
        )

    def _target(self, ball: Ball) -> Ball:
        """Return it in another shade of its own hue. The first shade is the one that is noted."""
        ranges, (_, saturation, value) = self._ranges, _hsv(ball.colour)
        saturation *= self._drawn(f"target {ball.name} saturation", ranges.target_saturation, 1.0)
        value *= self._drawn(f"target {ball.name} value", ranges.target_value, 1.0)
        colour = _rgb(self._target_hue(ball), saturation, value)
        if ball == self._world.target:
            self._note_colour("target", colour)
        return ball.model_copy(update={"colour": colour})

    def _target_hue(self, ball: Ball) -> float:
        turn = self._drawn(f"target {ball.name} hue", self._ranges.target_hue_deg, 0.0)
        return hue_degrees(ball.colour) + turn

    def _conditions(self, conditions: Conditions) -> Conditions:
        drawn = {}
        for name in type(conditions).model_fields:
            key = "wheel_gain" if name.startswith("wheel_gain") else name
            drawn[name] = self._number(name, getattr(self._ranges, key), getattr(conditions, name))
        return conditions.model_copy(update=drawn)

    def _colour(self, name: str, written: Rgb) -> Rgb:
        """Return a colour whose hue is no target's, as far as whole levels can tell a dull one's."""
        hue, saturation, value = _hsv(written)
        if self._hues:
            hue = hue_at(self._hues, self._share(f"{name} hue"))
        saturation = self._drawn(f"{name} saturation", self._ranges.colour_saturation, saturation)
        return _rgb(hue, saturation, self._drawn(f"{name} value", self._ranges.colour_value, value))

    def _texture(self, name: str, written: Texture | None) -> Texture | None:
        ranges = self._ranges
        if ranges.patterns is None:
            return written
        old = written or Texture(pattern="plain")
        pattern = ranges.patterns[int(len(ranges.patterns) * self._share(f"{name}_pattern"))]
        self.drawn[f"{name}_pattern"] = pattern
        scale = self._number(f"{name}_pattern_scale_m", ranges.pattern_scale_m, old.scale_m)
        contrast = self._number(f"{name}_pattern_contrast", ranges.pattern_contrast, old.contrast)
        return None if pattern == "plain" else Texture(pattern=pattern, scale_m=scale, contrast=contrast)

    def _note_colour(self, name: str, colour: Rgb) -> Rgb:
        parts = zip(("hue_deg", "saturation", "value"), _hsv(colour), strict=True)
        self.drawn |= {f"{name}_{part}": round(value, 4) for part, value in parts}
        return colour

    def _number(self, name: str, limits: Limits | None, written: float) -> float:
        """Return a number, drawn or as it was, and note it."""
        number = self._drawn(name, limits, written)
        if limits is not None:
            self.drawn[name] = number
        return number

    def _drawn(self, name: str, limits: Limits | None, written: float) -> float:
        """Return a number within limits, to four places, so that its text is exact."""
        if limits is None:
            return written
        low, high = limits
        return round(low + (high - low) * self._share(name), 4)

    def _share(self, name: str) -> float:
        return Random(f"{self._seed}:{name}").random()


def _free_hues(world: WorldDescription, taken: Iterable[float]) -> list[Arc]:
    """Return the hues that are far enough from every one that a target has drawn; none where hues are to stay."""
    gap = world.randomisation.hue_gap_deg
    if gap is None:
        return []
    free = free_arcs(taken, gap)
    if not free:
        key, fault = "randomisation.hue_gap_deg", "it leaves no hue beside those of the targets"
        raise DescriptionError(f"the world {world.name!r}", key, f"{fault}, got {gap:g}", "Take a smaller one")
    return free


def _hsv(colour: Rgb) -> tuple[float, float, float]:
    """Return hue in degrees, saturation and value in 0 to 1."""
    red, green, blue = (part / 255 for part in colour)
    hue, saturation, value = colorsys.rgb_to_hsv(red, green, blue)
    return 360 * hue, saturation, value


def _rgb(hue: float, saturation: float, value: float) -> Rgb:
    """Return a colour; more saturation or value than there can be is as much as can be."""
    red, green, blue = colorsys.hsv_to_rgb(hue / 360 % 1, min(saturation, 1.0), min(value, 1.0))
    return round(255 * red), round(255 * green), round(255 * blue)


def describe_light(light: Light) -> DrawnValues:
    """Return by name what a seed draws of the light with every layout."""
    return {f"light_{name}": getattr(light, name) for name in ("azimuth_rad", "elevation_rad", "brightness")}


def describe_conditions(conditions: Conditions) -> DrawnValues:
    """Return by name the conditions that are not perfect."""
    values: DrawnValues = conditions.model_dump(exclude_defaults=True)
    return values


def describe_picture(drawn: DrawnValues) -> DrawnValues:
    """Return ``picture_brightness``, the light's times the camera's exposure, where both are among what was drawn.

    Pictures that a dim lamp and a short exposure make dark together have neither of the two in common.
    """
    light, exposure = drawn.get("light_brightness"), drawn.get("camera_exposure")
    if isinstance(light, float) and isinstance(exposure, float):
        return {"picture_brightness": round(light * exposure, 4)}
    return {}
