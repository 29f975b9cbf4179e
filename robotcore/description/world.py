"""The description of a world: floor, lines, walls, obstacles, targets, light, and the values that a seed may change.

The origin of the world's frame is in the middle of the floor, and z points up. Keys end in their unit.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from robotcore.description.conditions import Brightness, Conditions, Elevation, Light, Randomisation
from robotcore.description.floor_image import FloorImage
from robotcore.description.lines import MAX_LINE_POINTS, Line
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
from robotcore.errors import Mistake
from robotcore.geometry import Pose
from robotcore.text import pluralize

Distance = Annotated[float, Field(ge=0, le=1000)]
Scale = Annotated[float, Field(ge=0.1, le=10)]
Outline = tuple[tuple[float, float], ...]
"""The corners of a convex polygon on the floor, counter-clockwise, in metres."""

CYLINDER_SIDES = 24
"""The number of sides of the prism by which every simulator models a cylinder."""

_ANGLES = [side * (math.tau / CYLINDER_SIDES) for side in range(CYLINDER_SIDES)]
_UNIT_CIRCLE = [(math.cos(angle), math.sin(angle)) for angle in _ANGLES]


def round_outline(x: float, y: float, radius: float) -> Outline:
    """Return a regular polygon with `CYLINDER_SIDES` corners.

    x, y, radius: the circle through the corners, in metres.
    """
    return tuple((x + radius * cos, y + radius * sin) for cos, sin in _UNIT_CIRCLE)


class Floor(StrictModel):
    """The floor, a rectangle. The ground beyond the floor has the same colour.

    >>> Floor(length_m=4.0, width_m=3.0, colour="sand").colour
    (205, 190, 160)
    """

    length_m: Metres
    """The length of the floor along x, in metres."""
    width_m: Metres
    """The width of the floor along y, in metres."""
    colour: Colour = (190, 185, 175)
    texture: Texture | None = None
    image: Annotated[FloorImage | None, Field(description='a table: { file = "course.png", length_m = 2.0 }')] = None
    """The picture on the floor. It covers the texture, and the lines cover the picture."""


class Walls(StrictModel):
    """Four walls around the floor. Their inner faces are at the floor's edges.

    >>> Walls(height_m=0.4).thickness_m
    0.05
    """

    height_m: Metres
    thickness_m: Metres = 0.05
    colour: Colour = COLOURS["white"]
    texture: Texture | None = None


class Prism(StrictModel):
    """The base class of obstacles and walls, which have vertical sides and stand on the floor."""

    name: Name
    x_m: Coordinate = 0.0
    """The x coordinate of the body's middle in the world's frame, in metres."""
    y_m: Coordinate = 0.0
    """The y coordinate of the body's middle in the world's frame, in metres."""
    yaw_rad: Radians = 0.0
    """The angle from the world's x axis to the body's x axis, in radians, positive to the left."""
    height_m: Metres
    colour: Colour
    texture: Texture | None = None

    @property
    def local_outline(self) -> Outline:
        """The outline on the floor, in the body's own frame."""
        raise NotImplementedError

    @property
    def outline(self) -> Outline:
        """The outline on the floor, in the world's frame."""
        (x, y), cos, sin = (self.x_m, self.y_m), math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return tuple((x + a * cos - b * sin, y + a * sin + b * cos) for a, b in self.local_outline)


class Box(Prism):
    """A box on the floor.

    >>> box = Box(shape="box", name="crate", x_m=1.0, length_m=0.4, width_m=0.2, height_m=0.3, colour="brown")
    >>> box.outline
    ((1.2, 0.1), (0.8, 0.1), (0.8, -0.1), (1.2, -0.1))
    """

    shape: Literal["box"]
    length_m: Metres
    """The length of the box along its own x axis, in metres."""
    width_m: Metres
    """The width of the box along its own y axis, in metres."""

    @property
    def local_outline(self) -> Outline:
        a, b = self.length_m / 2, self.width_m / 2
        return ((a, b), (-a, b), (-a, -b), (a, -b))


class Cylinder(Prism):
    """An upright cylinder on the floor, modelled as a prism of `CYLINDER_SIDES` sides.

    >>> from robotcore.description.world import CYLINDER_SIDES
    >>> drum = Cylinder(shape="cylinder", name="drum", y_m=1.0, radius_m=0.15, height_m=0.3, colour="grey")
    >>> len(drum.outline) == CYLINDER_SIDES
    True
    """

    shape: Literal["cylinder"]
    radius_m: Metres

    @property
    def local_outline(self) -> Outline:
        return round_outline(0.0, 0.0, self.radius_m)


Obstacle = Annotated[Box | Cylinder, Field(discriminator="shape")]


class Ball(StrictModel):
    """A target: a ball on the floor.

    >>> Ball(name="ball", radius_m=0.1, colour="green", x_m=1.35, y_m=1.2)
    Ball(name='ball', radius_m=0.1, colour=(40, 170, 60), x_m=1.35, y_m=1.2)
    """

    name: Name
    radius_m: Metres
    colour: Colour
    x_m: Coordinate
    """The x coordinate of the ball's middle in the world's frame, in metres."""
    y_m: Coordinate
    """The y coordinate of the ball's middle in the world's frame, in metres."""

    @property
    def outline(self) -> Outline:
        """The outline of the ball as seen from above, in the world's frame."""
        return round_outline(self.x_m, self.y_m, self.radius_m)


class Start(StrictModel):
    """The pose of the axle's centre in the world's frame at the start of a run.

    >>> Start(x_m=-1.0, yaw_rad=0.5).pose
    Pose(x=-1 m, y=0 m, heading=0.5 rad)
    """

    x_m: Coordinate = 0.0
    y_m: Coordinate = 0.0
    yaw_rad: Radians = 0.0

    @property
    def pose(self) -> Pose:
        return Pose(self.x_m, self.y_m, self.yaw_rad)


class Variation(StrictModel):
    """The intervals from which a seed draws the layout of a world. A value without an interval does not change.

    >>> variation = Variation(place_x_m=(-1.5, 1.5), gap_m=0.4)
    >>> variation.place_x_m, variation.yaw_rad is None
    ((-1.5, 1.5), True)
    """

    place_x_m: Between[Coordinate] | None = None
    """The interval for the x coordinates of the start, of the obstacles and of the targets, in metres."""
    place_y_m: Between[Coordinate] | None = None
    """The interval for the y coordinates of the start, of the obstacles and of the targets, in metres."""
    yaw_rad: Between[Radians] | None = None
    """The interval for the headings of the robot at the start and of the obstacles, in radians."""
    obstacle_scale: Between[Scale] = (1.0, 1.0)
    """The interval for the factor by which the length and the width of an obstacle are multiplied."""
    gap_m: Annotated[float, Field(ge=0, le=100)] = 0.3
    """The least gap between two bodies, and between a body and a wall, in metres."""
    target_distance_m: Between[Distance] | None = None
    """The interval for the distance from the start to the middle of the first target, in metres."""
    target_hidden: bool = False
    """Whether obstacles must hide the first target from a robot that turns on the spot at the start."""
    light_azimuth_rad: Between[Radians] | None = None
    light_elevation_rad: Between[Elevation] | None = None
    light_brightness: Between[Brightness] | None = None


class WorldDescription(StrictModel):
    """The description of a world, and the ranges from which a seed draws its variations.

    >>> from robotcore.description import Floor, Walls, load_world
    >>> world = load_world("arena")
    >>> world
    <WorldDescription arena: 4 x 4 m, 6 obstacles, 1 target>
    >>> world.target.name, world.start.pose
    ('ball', Pose(x=-1.4 m, y=-1.3 m, heading=3 rad))
    >>> WorldDescription(name="hall", floor=Floor(length_m=6.0, width_m=4.0), walls=Walls(height_m=0.4))
    <WorldDescription hall: 6 x 4 m>
    """

    name: Name
    summary: str = ""
    """One line about the world, for `robotcore worlds`."""
    floor: Floor
    lines: Annotated[tuple[Line, ...], Field(description="a list of tables: [[lines]]")] = ()
    """The lines on the floor. A line covers the lines before it."""
    walls: Walls | None = None
    start: Start = Start()
    light: Light = Light()
    targets: Annotated[tuple[Ball, ...], Field(description="a list of tables: [[targets]]")] = ()
    obstacles: Annotated[tuple[Obstacle, ...], Field(description="a list of tables: [[obstacles]]")] = ()
    conditions: Conditions = Conditions()
    variation: Variation | None = None
    """The intervals from which a seed draws layouts. With None, a seed draws positions from the whole floor."""
    randomisation: Randomisation = Randomisation()

    def __repr__(self) -> str:
        contents = {"obstacle": self.obstacles, "target": self.targets, "line": self.lines}
        parts = [f"{self.floor.length_m:g} x {self.floor.width_m:g} m"]
        parts += [pluralize(len(things), name) for name, things in contents.items() if things]
        return f"<WorldDescription {self.name}: {', '.join(parts)}>"

    @model_validator(mode="after")
    def _check_names(self) -> WorldDescription:
        require_unique("bodies", (body.name for body in (*self.prisms, *self.targets)))
        return self

    @model_validator(mode="after")
    def _check_lines(self) -> WorldDescription:
        count = sum(len(line.points_m) for line in self.lines)
        if count > MAX_LINE_POINTS:
            problem = f"the lines have {count} points, and at most {MAX_LINE_POINTS} are allowed"
            raise Mistake(problem, "Take fewer points", kind="too-many-points")
        return self

    @property
    def wall_prisms(self) -> tuple[Box, ...]:
        """The four walls as boxes, or nothing in a world without walls.

        The north wall and the south wall include the corners.
        """
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
        """All walls, followed by all obstacles."""
        return (*self.wall_prisms, *self.obstacles)

    @property
    def bodies(self) -> tuple[Box | Cylinder | Ball, ...]:
        """All obstacles, followed by all targets."""
        return (*self.obstacles, *self.targets)

    @property
    def target(self) -> Ball | None:
        """The first target, which apps must find; None in a world without targets."""
        return self.targets[0] if self.targets else None
