"""The description of a world: floor, walls, obstacles, targets, light, and what a seed may change.

World frame: origin in the middle of the floor, z up. Keys end in their unit.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from robotcore.description.conditions import Brightness, Conditions, Elevation, Light, Randomisation
from robotcore.description.texture import Texture
from robotcore.description.types import (
    COLOURS,
    Between,
    Colour,
    Coordinate,
    Metres,
    Name,
    Radians,
    StrictModel,
    require_unique,
)
from robotcore.geometry import Pose

Distance = Annotated[float, Field(ge=0, le=1000)]
Scale = Annotated[float, Field(ge=0.1, le=10)]
Outline = tuple[tuple[float, float], ...]
"""The corners of a convex polygon on the floor, counter-clockwise."""

CYLINDER_SIDES = 24
"""Every simulator draws and measures a cylinder as a prism with this number of sides."""


def round_outline(x: float, y: float, radius: float) -> Outline:
    """Return the polygon with `CYLINDER_SIDES` corners on a circle, in metres."""
    step = math.tau / CYLINDER_SIDES
    return tuple((x + radius * math.cos(i * step), y + radius * math.sin(i * step)) for i in range(CYLINDER_SIDES))


class Floor(StrictModel):
    """The floor, a rectangle. Beyond its edge the ground continues in the same colour."""

    length_m: Metres
    """Along x."""
    width_m: Metres
    """Along y."""
    colour: Colour = (190, 185, 175)
    texture: Texture | None = None


class Walls(StrictModel):
    """Four walls around the floor, outside its edge."""

    height_m: Metres
    thickness_m: Metres = 0.05
    colour: Colour = COLOURS["white"]
    texture: Texture | None = None


class Prism(StrictModel):
    """The base class of the bodies with upright sides that stand on the floor."""

    name: Name
    x_m: Coordinate = 0.0
    """Its middle, in the world."""
    y_m: Coordinate = 0.0
    """Its middle, in the world."""
    yaw_rad: Radians = 0.0
    """The angle to the left between the world's x axis and the body's own."""
    height_m: Metres
    colour: Colour
    texture: Texture | None = None

    @property
    def local_outline(self) -> Outline:
        """The outline in the body's own frame."""
        raise NotImplementedError

    @property
    def outline(self) -> Outline:
        """The outline in the world's frame."""
        pose = Pose(self.x_m, self.y_m, self.yaw_rad)
        return tuple(pose.to_world(x, y) for x, y in self.local_outline)


class Box(Prism):
    """A box on the floor."""

    shape: Literal["box"]
    length_m: Metres
    """Along its own x axis."""
    width_m: Metres
    """Along its own y axis."""

    @property
    def local_outline(self) -> Outline:
        a, b = self.length_m / 2, self.width_m / 2
        return ((a, b), (-a, b), (-a, -b), (a, -b))


class Cylinder(Prism):
    """A cylinder on the floor, as a prism of 24 sides."""

    shape: Literal["cylinder"]
    radius_m: Metres

    @property
    def local_outline(self) -> Outline:
        return round_outline(0.0, 0.0, self.radius_m)


Obstacle = Annotated[Box | Cylinder, Field(discriminator="shape")]


class Ball(StrictModel):
    """A target: a ball on the floor."""

    name: Name
    radius_m: Metres
    colour: Colour
    x_m: Coordinate
    """Its middle, in the world."""
    y_m: Coordinate
    """Its middle, in the world."""

    @property
    def outline(self) -> Outline:
        """The outline of the ball from above, in the world's frame."""
        return round_outline(self.x_m, self.y_m, self.radius_m)


class Start(StrictModel):
    """The pose of the robot at the start: the middle of its axle."""

    x_m: Coordinate = 0.0
    y_m: Coordinate = 0.0
    yaw_rad: Radians = 0.0

    @property
    def pose(self) -> Pose:
        return Pose(self.x_m, self.y_m, self.yaw_rad)


class Variation(StrictModel):
    """The intervals from which a seed draws the layout of a world. A value without an interval does not change."""

    place_x_m: Between[Coordinate] | None = None
    """The x coordinates of the start, of each obstacle and of each target."""
    place_y_m: Between[Coordinate] | None = None
    """The y coordinates of the start, of each obstacle and of each target."""
    yaw_rad: Between[Radians] | None = None
    """The headings of the robot at the start and of each obstacle."""
    obstacle_scale: Between[Scale] = (1.0, 1.0)
    """The factor by which the length and width of an obstacle are multiplied. Its height does not change."""
    gap_m: Annotated[float, Field(ge=0, le=100)] = 0.3
    """The least distance between two bodies, and between a body and a wall."""
    target_distance_m: Between[Distance] | None = None
    """The distance from the start to the middle of the first target."""
    target_hidden: bool = False
    """Whether obstacles must hide the first target from the robot at the start, whatever the robot's heading is."""
    light_azimuth_rad: Between[Radians] | None = None
    light_elevation_rad: Between[Elevation] | None = None
    light_brightness: Between[Brightness] | None = None


class WorldDescription(StrictModel):
    """A world, and the ranges from which a seed draws its variations."""

    name: Name
    summary: str = ""
    """One line for lists."""
    floor: Floor
    walls: Walls | None = None
    start: Start = Start()
    light: Light = Light()
    targets: Annotated[tuple[Ball, ...], Field(description="a list of tables: [[targets]]")] = ()
    obstacles: Annotated[tuple[Obstacle, ...], Field(description="a list of tables: [[obstacles]]")] = ()
    conditions: Conditions = Conditions()
    variation: Variation | None = None
    """The intervals for layouts. With None, a seed draws positions from the whole floor."""
    randomisation: Randomisation = Randomisation()

    @model_validator(mode="after")
    def _check_names(self) -> WorldDescription:
        require_unique("bodies", (body.name for body in (*self.prisms, *self.targets)))
        return self

    @property
    def wall_prisms(self) -> tuple[Box, ...]:
        """The four walls as boxes. The corners belong to the north wall and the south wall."""
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
        """The walls, then the obstacles."""
        return (*self.wall_prisms, *self.obstacles)

    @property
    def bodies(self) -> tuple[Box | Cylinder | Ball, ...]:
        """The obstacles, then the targets."""
        return (*self.obstacles, *self.targets)

    @property
    def target(self) -> Ball | None:
        """The first target, or None if there is none. An app that searches for a target must find this one."""
        return self.targets[0] if self.targets else None
