"""The light of a world."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from robotcore.description.conditions import Brightness, Conditions, Elevation, Light, Randomisation
from robotcore.description.texture import Texture
from robotcore.description.types import (
    COLOURS,
    Angle,
    Between,
    Colour,
    Coordinate,
    Metres,
    Name,
    StrictModel,
    require_unique,
)
from robotcore.geometry import Pose

Distance = Annotated[float, Field(ge=0, le=1000)]
Scale = Annotated[float, Field(ge=0.1, le=10)]
Outline = tuple[tuple[float, float], ...]
"""The corners of a convex polygon on the floor, counter-clockwise."""

CYLINDER_SIDES = 24
"""A cylinder is this prism wherever it is drawn, touched or measured, the same on every simulator."""


def round_outline(x: float, y: float, radius: float) -> Outline:
    """Return the prism's outline that stands for a circle."""
    step = math.tau / CYLINDER_SIDES
    return tuple((x + radius * math.cos(i * step), y + radius * math.sin(i * step)) for i in range(CYLINDER_SIDES))


class Floor(StrictModel):
    """A rectangle with the origin in its middle; beyond it the same ground goes on."""

    length_m: Metres
    width_m: Metres
    colour: Colour = (190, 185, 175)
    texture: Texture | None = None


class Walls(StrictModel):
    """Four walls around the floor, standing outside its edge."""

    height_m: Metres
    thickness_m: Metres = 0.05
    colour: Colour = COLOURS["white"]
    texture: Texture | None = None


class Prism(StrictModel):
    """What all upright things on the floor have: a place, a height, a look."""

    name: Name
    x_m: Coordinate = 0.0
    y_m: Coordinate = 0.0
    yaw_rad: Angle = 0.0
    height_m: Metres
    colour: Colour
    texture: Texture | None = None

    @property
    def local_outline(self) -> Outline:
        """Its outline around its own middle, before it is turned."""
        raise NotImplementedError

    @property
    def outline(self) -> Outline:
        """Its outline in the world."""
        pose = Pose(self.x_m, self.y_m, self.yaw_rad)
        return tuple(pose.to_world(x, y) for x, y in self.local_outline)


class Box(Prism):
    """A box that stands on the floor."""

    shape: Literal["box"]
    length_m: Metres
    width_m: Metres

    @property
    def local_outline(self) -> Outline:
        a, b = self.length_m / 2, self.width_m / 2
        return ((a, b), (-a, b), (-a, -b), (a, -b))


class Cylinder(Prism):
    """A cylinder that stands on the floor; a prism of 24 sides."""

    shape: Literal["cylinder"]
    radius_m: Metres

    @property
    def local_outline(self) -> Outline:
        return round_outline(0.0, 0.0, self.radius_m)


Obstacle = Annotated[Box | Cylinder, Field(discriminator="shape")]


class Ball(StrictModel):
    """A target: a ball that lies on the floor."""

    name: Name
    radius_m: Metres
    colour: Colour
    x_m: Coordinate
    y_m: Coordinate

    @property
    def outline(self) -> Outline:
        """Its outline in the world, in plan."""
        return round_outline(self.x_m, self.y_m, self.radius_m)


class Start(StrictModel):
    """Where the robot begins: the middle of its axle."""

    x_m: Coordinate = 0.0
    y_m: Coordinate = 0.0
    yaw_rad: Angle = 0.0

    @property
    def pose(self) -> Pose:
        return Pose(self.x_m, self.y_m, self.yaw_rad)


class Variation(StrictModel):
    """From what a seed draws. What is left out stays as the file has it.

    Start, obstacles and targets get a place; start and obstacles a heading. ``obstacle_scale`` is of an
    obstacle's outline. ``target_distance_m`` is from the start to the first target's middle; where that is to
    be hidden, nothing of it is in line of sight at the start, however the robot turns.
    """

    place_x_m: Between[Coordinate] | None = None
    place_y_m: Between[Coordinate] | None = None
    yaw_rad: Between[Angle] | None = None
    obstacle_scale: Between[Scale] = (1.0, 1.0)
    gap_m: Annotated[float, Field(ge=0, le=100)] = 0.3
    target_distance_m: Between[Distance] | None = None
    target_hidden: bool = False
    light_azimuth_rad: Between[Angle] | None = None
    light_elevation_rad: Between[Elevation] | None = None
    light_brightness: Between[Brightness] | None = None


class WorldDescription(StrictModel):
    """A world as it stands, and what a seed may make of it."""

    name: Name
    summary: str = ""
    floor: Floor
    walls: Walls | None = None
    start: Start = Start()
    light: Light = Light()
    targets: Annotated[tuple[Ball, ...], Field(description="a list of tables: [[targets]]")] = ()
    obstacles: Annotated[tuple[Obstacle, ...], Field(description="a list of tables: [[obstacles]]")] = ()
    conditions: Conditions = Conditions()
    variation: Variation | None = None
    randomisation: Randomisation = Randomisation()

    @model_validator(mode="after")
    def _names_differ(self) -> WorldDescription:
        require_unique("things", (thing.name for thing in (*self.prisms, *self.targets)))
        return self

    @property
    def wall_prisms(self) -> tuple[Box, ...]:
        """The four walls as boxes: north and south cover the corners."""
        if self.walls is None:
            return ()
        length, width, thick = self.floor.length_m, self.floor.width_m, self.walls.thickness_m
        x, y = (length + thick) / 2, (width + thick) / 2
        sides = (
            ("north", 0.0, y, length + 2 * thick, thick),
            ("south", 0.0, -y, length + 2 * thick, thick),
            ("east", x, 0.0, thick, width),
            ("west", -x, 0.0, thick, width),
        )
        return tuple(
            Box.model_construct(
                shape="box",
                name=f"wall-{side}",
                x_m=at_x,
                y_m=at_y,
                length_m=along_x,
                width_m=along_y,
                height_m=self.walls.height_m,
                colour=self.walls.colour,
                texture=self.walls.texture,
            )
            for side, at_x, at_y, along_x, along_y in sides
        )

    @property
    def prisms(self) -> tuple[Box | Cylinder, ...]:
        """Everything upright that can be bumped into: walls, then obstacles."""
        return (*self.wall_prisms, *self.obstacles)

    @property
    def things(self) -> tuple[Box | Cylinder | Ball, ...]:
        """What stands or lies on the floor: obstacles, then targets."""
        return (*self.obstacles, *self.targets)

    @property
    def target(self) -> Ball | None:
        """The first target: the one that an app is measured by."""
        return self.targets[0] if self.targets else None
