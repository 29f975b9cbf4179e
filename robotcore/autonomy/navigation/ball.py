"""Locates a ball of a known size by camera and range sensor."""

from __future__ import annotations

import math

from robotcore.autonomy.navigation.mapping import PoseHistory
from robotcore.autonomy.vision import Blob, ColourDetector, draw_boxes
from robotcore.geometry import Pose
from robotcore.hal.robot import Robot, Role

SEEN_PX = 30
"""The least area of a blob from which a ball is located."""

KEPT_PX = 8
"""The least area of a blob that counts as a sight of the ball."""

AGREE_M = 0.15
"""The greatest difference between the distances by size and by echo if both are of the ball."""

Point = tuple[float, float]


class BallTracker:
    """Locates a ball of one hue in the odometry's frame.

    hue: the ball's hue, by name or in degrees.
    radius: the ball's radius in metres.

    >>> BallTracker("green", radius=0.1)
    BallTracker(radius=0.1, place=None, lost_for=0)
    """

    def __init__(self, hue: str | float, radius: float) -> None:
        self.radius = radius
        self.place: Point | None = None
        """The last position of the ball that was measured well, in metres; None before the first."""
        self.lost_for = 0.0
        """The time since the ball was last in a picture, in seconds."""
        self.is_in_sight = False
        """Whether enough of the ball is in the last picture to locate it."""
        self._seen_at = 0.0
        self._past = PoseHistory()
        self._detector = ColourDetector(hue, min_area=KEPT_PX)

    def __repr__(self) -> str:
        return f"BallTracker(radius={self.radius:g}, place={self.place}, lost_for={self.lost_for:g})"

    def look(self, robot: Robot, pose: Pose) -> Blob | None:
        """Update the ball's place from the newest picture, and return its blob; None without a blob of the hue.

        The picture with the blob's box is shown on the robot's display, if it has one.

        robot: the robot.
        pose: the robot's pose now, by odometry.
        """
        self._past.add(robot.clock.now(), pose)
        frame = robot.camera.read()
        blobs = self._detector.find(frame.image, robot.camera.intrinsics)[:1]
        if robot.has(Role.DISPLAY):
            robot.display.show(draw_boxes(frame.image, blobs))
        blob = blobs[0] if blobs else None
        self._seen_at = frame.time if blob else self._seen_at
        self.lost_for = 0.0 if blob else robot.clock.now() - self._seen_at
        self.is_in_sight = blob is not None and blob.area >= SEEN_PX
        if blob and (self.is_in_sight or self.place is None):
            self.place = self._place_of(blob, robot, self._past.at(frame.time))
        return blob

    def forget(self) -> None:
        """Delete the ball's place, for a ball that is not at its place any more."""
        self.place = None

    def _place_of(self, blob: Blob, robot: Robot, pose: Pose) -> Point:
        """Return the position of the ball of a blob, seen from a pose.

        The distance follows from the ball's size in the picture. The echo replaces it if the two agree, or if the blob
        touches the picture's edge.
        """
        away = self.radius * robot.camera.intrinsics.focal_length / blob.radius
        echo = robot.range.read().distance + self.radius
        is_in_cone = abs(blob.bearing) < robot.range.cone / 2
        if is_in_cone and (abs(echo - away) < AGREE_M or (blob.is_clipped and math.isfinite(echo))):
            away = echo
        eye = pose.moved(robot.camera.mount)
        return eye.to_world(away * math.cos(blob.bearing), away * math.sin(blob.bearing))
