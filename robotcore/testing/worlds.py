"""The worlds of the conformance kit: open ground, and worlds with one object in front of a sensor.

The robot starts at the origin and faces along x. ``mount`` is the mount of the sensor. ``distance`` is the distance
from the sensor in metres. ``bearing`` is the direction from the sensor in radians, positive to the left.
"""

from __future__ import annotations

import math

from robotcore.description import COLOURS, Ball, Box, Cylinder, Floor, Mount, Start, WorldDescription
from robotcore.geometry import Pose

GROUND = Floor(length_m=12.0, width_m=12.0)
WALL_THICKNESS_M = 0.2
POST_RADIUS_M = 0.03
BALL_RADIUS_M = 0.1


def empty(start: Start | None = None) -> WorldDescription:
    """Return a world without objects, by default with the start at the origin."""
    return WorldDescription(name="empty", floor=GROUND, start=start or Start())


def wall(mount: Mount, distance: float) -> WorldDescription:
    """Return a world with a wall perpendicular to the sensor's axis. Its near side is at ``distance``."""
    return _place_box(mount, distance, "wall", "white", (WALL_THICKNESS_M, 4.0, mount.z_m + 0.5))


def post(mount: Mount, distance: float, bearing: float) -> WorldDescription:
    """Return a world with a thin post. Its near side is at ``distance``."""
    x, y = _place(mount, distance + POST_RADIUS_M, bearing)
    thin = Cylinder(
        shape="cylinder",
        name="post",
        colour=COLOURS["white"],
        x_m=x,
        y_m=y,
        radius_m=POST_RADIUS_M,
        height_m=mount.z_m + 0.5,
    )
    return _with(thin)


def ball(mount: Mount, distance: float, bearing: float) -> WorldDescription:
    """Return a world with a green ball on the floor. Its centre is at the horizontal ``distance``."""
    x, y = _place(mount, distance, bearing)
    green = Ball(name="ball", colour=COLOURS["green"], x_m=x, y_m=y, radius_m=BALL_RADIUS_M)
    return empty().model_copy(update={"targets": (green,)})


def box(mount: Mount, distance: float, colour: str) -> WorldDescription:
    """Return a world with a box on the sensor's axis, half as high as the sensor. Its near side is at ``distance``."""
    return _place_box(mount, distance, "box", colour, (0.2, 0.3, mount.z_m / 2))


def _place_box(
    mount: Mount, distance: float, name: str, colour: str, size: tuple[float, float, float]
) -> WorldDescription:
    length, width, height = size
    x, y = _place(mount, distance + length / 2, 0.0)
    return _with(
        Box(
            shape="box",
            name=name,
            colour=COLOURS[colour],
            x_m=x,
            y_m=y,
            yaw_rad=mount.yaw_rad,
            length_m=length,
            width_m=width,
            height_m=height,
        )
    )


def _with(obstacle: Box | Cylinder) -> WorldDescription:
    return empty().model_copy(update={"obstacles": (obstacle,)})


def _place(mount: Mount, distance: float, bearing: float) -> tuple[float, float]:
    sensor = Pose(mount.x_m, mount.y_m, mount.yaw_rad)
    return sensor.to_world(distance * math.cos(bearing), distance * math.sin(bearing))
