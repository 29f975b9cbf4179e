"""Where a ball of a known size lies, by eye and by echo."""

from __future__ import annotations

import math

from robotcore.autonomy.navigation.mapping import PoseHistory
from robotcore.autonomy.vision import Blob, ColourDetector, draw_boxes
from robotcore.geometry import Pose
from robotcore.hal.robot import Robot, Role

SEEN_PX = 30
KEPT_PX = 8
AGREE_M = 0.15

Point = tuple[float, float]


class BallTracker:
    """Keeps the place of a ball of one hue in the odometry's frame; ``radius`` in metres.

    ``place`` is where it was last seen well, None before; ``lost_for`` is how long none of it was seen, in seconds.
    """

    def __init__(self, hue: str | float, radius: float) -> None:
        self.radius = radius
        self.place: Point | None = None
        self.lost_for = 0.0
        self.is_in_sight = False
        self._seen_at = 0.0
        self._past = PoseHistory()
        self._detector = ColourDetector(hue, min_area=KEPT_PX)

    def look(self, robot: Robot, pose: Pose) -> Blob | None:
        """Return the largest patch of the hue, if there is one, and note where its ball lies; show what was found."""
        self._past.note(robot.clock.now(), pose)
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
        """Give the place up: the ball does not show where it should be."""
        self.place = None

    def _place_of(self, blob: Blob, robot: Robot, pose: Pose) -> Point:
        """Return where a ball lies that is seen from ``pose``.

        By its size, and by its echo where that agrees or the ball fills the picture.
        """
        away = self.radius * robot.camera.intrinsics.focal_length / blob.radius
        echo = robot.range.read().distance + self.radius
        is_heard = abs(blob.bearing) < robot.range.cone / 2
        if is_heard and (abs(echo - away) < AGREE_M or (blob.is_clipped and math.isfinite(echo))):
            away = echo
        eye = pose.moved(robot.camera.mount)
        return eye.to_world(away * math.cos(blob.bearing), away * math.sin(blob.bearing))
