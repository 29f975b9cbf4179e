"""Locates a ball of a known size by camera and range sensor."""

from __future__ import annotations

import math

from robotcore.autonomy.navigation.mapping import PoseHistory
from robotcore.autonomy.pending_routine import warn_if_dropped
from robotcore.autonomy.routines import Routine
from robotcore.autonomy.vision import DEFAULT_TOLERANCE, Blob, ColourDetector, draw_boxes
from robotcore.geometry import Pose
from robotcore.hal.robot import Robot, Role

MIN_POSITION_BLOB_PX = 30
"""A blob of at least this area, in pixels, gives the ball's position. A smaller one gives only its direction."""

MIN_BLOB_PX = 8
"""The least area of a blob, in pixels. Smaller blobs are ignored."""

MAX_ECHO_DIFFERENCE_M = 0.15
"""An echo comes from the ball if its distance differs by less than this from the distance seen in the picture."""

Point = tuple[float, float]


class BallTracker:
    """Measures the position of a ball of one hue, in the odometry's frame.

    hue: the ball's hue, by name or in degrees.
    radius: the ball's radius in metres.
    tolerance: the greatest difference between a pixel's hue and ``hue``, in degrees, see `ColourDetector`.

    >>> BallTracker("green", radius=0.1)
    BallTracker(radius=0.1, place=None, lost_for=0)
    """

    def __init__(self, hue: str | float, radius: float, tolerance: float = DEFAULT_TOLERANCE) -> None:
        self.radius = radius
        self.place: Point | None = None
        """The ball's last measured position (x, y) in the odometry's frame, in metres; None without a measurement."""
        self.lost_for = 0.0
        """0 if the newest picture shows the ball, else the time since the last picture that shows it, in seconds."""
        self.is_in_sight = False
        """Whether the newest picture gave ``place``: its blob has at least `MIN_POSITION_BLOB_PX` pixels."""
        self._seen_at = 0.0
        self._past, self._mounts = PoseHistory(), PoseHistory()
        self._detector = ColourDetector(hue, tolerance=tolerance, min_area=MIN_BLOB_PX)

    def __repr__(self) -> str:
        return f"BallTracker(radius={self.radius:g}, place={self.place}, lost_for={self.lost_for:g})"

    def look(self, robot: Robot, pose: Pose) -> Blob | None:
        """Update the ball's position from the newest picture, and return the ball's blob.

        Return None if the picture has no blob of the hue. If the robot has a display, the display shows the picture
        with a box around the blob.

        robot: the robot.
        pose: the robot's pose now, by odometry.
        """
        self._past.add(robot.clock.now(), pose)
        self._mounts.add(robot.clock.now(), robot.camera.mount)
        frame = robot.camera.read()
        blobs = self._detector.find(frame.image, robot.camera.intrinsics)[:1]
        if robot.has(Role.DISPLAY):
            robot.display.show(draw_boxes(frame.image, blobs) if blobs else frame.image)
        blob = blobs[0] if blobs else None
        self._seen_at = frame.time if blob else self._seen_at
        self.lost_for = 0.0 if blob else robot.clock.now() - self._seen_at
        self.is_in_sight = blob is not None and blob.area >= MIN_POSITION_BLOB_PX
        if blob and (self.is_in_sight or self.place is None):
            self.place = self._compute_position(blob, robot, self._past.at(frame.time), self._mounts.at(frame.time))
        return blob

    @warn_if_dropped
    def watch(self, robot: Robot) -> Routine[None]:
        """Call `look` in each tick. It does not end. Put it first in a `race`, so that it runs before the motion."""
        while True:
            self.look(robot, robot.drive.pose)
            yield

    def forget(self) -> None:
        """Delete the ball's position until the next call of `look`. Call it if the ball is not there any more."""
        self.place = None
        self.is_in_sight = False

    def _compute_position(self, blob: Blob, robot: Robot, pose: Pose, mount: Pose) -> Point:
        """Return the ball's position (x, y) in metres.

        The blob's size gives the distance. An echo at about the same distance replaces it. If the blob touches the
        picture's edge, its size is unknown, so any echo replaces it.

        pose, mount: the robot's pose, and the camera's pose on the robot, at the time of the picture.
        """
        away = self.radius * robot.camera.intrinsics.focal_length / blob.radius
        direction = mount.heading + blob.bearing
        is_in_cone = abs(direction - robot.range.mount.heading) < robot.range.cone / 2
        echo = _find_distance(mount, direction, robot.range.mount, robot.range.read().distance + self.radius)
        if is_in_cone and (abs(echo - away) < MAX_ECHO_DIFFERENCE_M or (blob.is_clipped and math.isfinite(echo))):
            away = echo
        eye = pose.compose(mount)
        return eye.to_world(away * math.cos(blob.bearing), away * math.sin(blob.bearing))


def _find_distance(camera: Pose, direction: float, sensor: Pose, radius: float) -> float:
    """Return the distance from the camera, in a direction, of the circle around the range sensor, in metres.

    camera, sensor: the poses of both on the robot.
    direction: the direction on the robot, in radians.
    radius: the circle's radius in metres.
    """
    x, y = sensor.x - camera.x, sensor.y - camera.y
    along, across = x * math.cos(direction) + y * math.sin(direction), y * math.cos(direction) - x * math.sin(direction)
    return along + math.sqrt(max(0.0, radius**2 - across**2))
