"""Draw the present state of an open robot as one picture: the camera, the world or the map from above, the readings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.canvas import FADED, INK, RULE, SERIES, Canvas, encode_png, shorten_text
from robotcore.description import RobotDescription, WorldDescription
from robotcore.geometry import Pose
from robotcore.hal.robot import Robot
from robotcore.kinds.camera import Frame
from robotcore.optics import Image
from robotcore.recording.summary import is_plausible
from robotcore.runtime.layers.devices import AppActuator, AppSensor
from robotcore.view.overhead import MapPath, Track, TrackPoint, draw_map
from robotcore.view.page import (
    EDGE,
    HEIGHT,
    MAP,
    SIDE,
    SIDE_WIDTH,
    TOP,
    begin_page,
    finish_page,
    require_writable,
    save_png,
)
from robotcore.view.picture import build_empty_world, draw_side_picture

_ROW = 34
_TEXT_PX = 15
_NAME_WIDTH, _TIME_WIDTH = 190, 90


class RobotPicture:
    """A picture of a robot, which a notebook shows.

    title: the robot's name and the time.
    image: the picture, BGR.
    """

    def __init__(self, title: str, image: Image) -> None:
        self.title, self.image = title, image

    def __repr__(self) -> str:
        return f"<RobotPicture of {self.title}>"

    def _repr_png_(self) -> bytes:
        return encode_png(self.image)

    def save(self, file: str | Path) -> None:
        """Write the picture as PNG. Raises UsageError if the file's ending is not .png, or it cannot be written."""
        require_writable(Path(file), option="")
        save_png(encode_png(self.image), Path(file), option="")


def draw_robot(
    robot: Robot,
    description: RobotDescription,
    path: Sequence[Pose] = (),
    *,
    world: WorldDescription | None = None,
    grid: OccupancyGrid | None = None,
) -> RobotPicture:
    """Return the picture of an open robot, 1600 pixels wide and 1000 high. This reads no device.

    It shows the last picture of the first camera, the last sample of each sensor, and the last command of each
    actuator other than motors, as the layers have limited it. A real robot has no true pose; then ``path`` is that of
    the odometry.

    robot: the robot as an app has it.
    description: the robot's description.
    path: the robot's poses, the present one at the end: the true poses in ``world``, or those of the odometry.
    world: the world in which the path lies; None to draw the path on an empty floor.
    grid: the map by the odometry, which is drawn in place of the world; None without a map.

    >>> from robotcore.testing import MockRobot
    >>> mock = MockRobot(range=[0.84])
    >>> draw_robot(mock.layered, mock.description, [Pose(0.0, 0.0, 0.0)])
    <RobotPicture of rover at 0.00 s>
    """
    path = [pose for pose in path if is_plausible(pose)]
    title = f"{robot.name} at {robot.clock.now():.2f} s"
    side_picture = draw_side_picture(_find_last_frame(robot), "no picture has been read")
    canvas = begin_page(
        robot.name, title.removeprefix(f"{robot.name} "), INK, _format_pose(path, is_true=world is not None)
    )
    _draw_readings(canvas, TOP + len(side_picture), robot)
    overhead = _draw_grid(grid, path) if grid else _draw_world(world or build_empty_world(path), description, path)
    return RobotPicture(title, finish_page(canvas, overhead, side_picture))


def _find_last_frame(robot: Robot) -> Image | None:
    samples = (each.latest for each in robot.devices.values() if isinstance(each, AppSensor))
    return next((sample.image for sample in samples if isinstance(sample, Frame)), None)


def _format_pose(path: Sequence[Pose], *, is_true: bool) -> str:
    if not path:
        return ""
    x, y, heading = path[-1]
    source = "true pose" if is_true else "odometry"
    return f"{source}: x {x:.2f} m, y {y:.2f} m, heading {heading:.2f} rad"


def _draw_world(world: WorldDescription, description: RobotDescription, path: Sequence[Pose]) -> Image:
    track = Track()
    track.points = [TrackPoint(0.0, "", pose) for pose in path]
    return draw_map(world, [MapPath(description, track, {}, {"": SERIES[0]})], MAP)


def _draw_grid(grid: OccupancyGrid, path: Sequence[Pose]) -> Image:
    drawn = grid.draw(path[-1] if path else None, [(pose.x, pose.y) for pose in path], MAP)
    height, width = drawn.shape[:2]
    left, top = (MAP - width) // 2, (MAP - height) // 2
    right, bottom = MAP - width - left, MAP - height - top
    framed = cv2.copyMakeBorder(drawn, top, bottom, left, right, cv2.BORDER_CONSTANT, value=RULE[::-1])
    return np.asarray(framed, np.uint8)


def _draw_readings(canvas: Canvas, top: int, robot: Robot) -> None:
    columns = (SIDE, SIDE + _NAME_WIDTH, SIDE + SIDE_WIDTH - _TIME_WIDTH)
    width = columns[2] - columns[1] - 12
    y = top + 44.0
    for name, reading, time in _list_readings(robot):
        if y > HEIGHT - EDGE:
            break
        canvas.write_text((columns[0], y), shorten_text(name, _NAME_WIDTH - 12, _TEXT_PX), FADED, _TEXT_PX)
        canvas.write_text((columns[1], y), shorten_text(reading, width, _TEXT_PX), INK, _TEXT_PX)
        canvas.write_text((columns[2], y), time, FADED, _TEXT_PX)
        y += _ROW


def _list_readings(robot: Robot) -> Iterator[tuple[str, str, str]]:
    """Yield the name, the last sample or the last limited command, and the sample's time of each device with one."""
    for device in robot.devices.values():
        if isinstance(device, AppActuator) and (command := device.format_state()):
            yield device.name, command, ""
        elif isinstance(device, AppSensor) and device.latest is not None:
            sample: Any = device.latest
            yield device.name, device.format_sample(sample), f"{sample.time:.2f} s"
