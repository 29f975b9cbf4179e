"""A path of straight lines and arcs, and the place of a robot beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from robotcore.geometry import Pose, wrap_angle


@dataclass(frozen=True)
class Piece:
    """A straight line or an arc."""

    start: Pose
    """The pose of the robot at the start."""
    length: float
    """The length in metres."""
    curvature: float = 0.0
    """The curvature in 1/m, positive to the left; 0 for a straight line."""

    def compute_pose(self, progress: float) -> Pose:
        """Return the pose on the piece, ``progress`` metres from its start."""
        return self.start.advance(progress, self.curvature * progress)

    @property
    def end(self) -> Pose:
        """The pose of the robot at the end."""
        return self.compute_pose(self.length)


class Place(NamedTuple):
    """The place of a robot beside a path."""

    progress: float
    """The distance along the path from its start, in metres."""
    cross_track: float
    """The distance from the path, in metres, positive if the robot is on the left of it."""
    heading_error: float
    """The angle from the path's direction to the robot's heading, in radians."""
    curvature: float
    """The curvature of the path a little ahead, in 1/m."""


class Path:
    """A chain of pieces. On a path backward, each piece has a negative length, and the robot's heading points back."""

    def __init__(self, pieces: Sequence[Piece]) -> None:
        self.pieces = tuple(pieces)
        self.length = sum(piece.length for piece in pieces)

    @property
    def end(self) -> Pose:
        """The pose of the robot at the end."""
        return self.pieces[-1].end

    @property
    def curvature(self) -> float:
        """The curvature of the sharpest piece, in 1/m, not negative."""
        return max(abs(piece.curvature) for piece in self.pieces)

    def locate(self, pose: Pose, progress: float, preview: float = 0.0) -> Place:
        """Return the place of a robot.

        pose: the pose of the robot.
        progress: the last progress, from which the search begins.
        preview: the distance ahead at which the curvature is returned, in metres.
        """
        for _ in range(3):  # Newton's method
            piece, begin = self._find_piece(progress)
            there = piece.compute_pose(progress - begin)
            ahead, side = there.to_local(pose.x, pose.y)
            progress += ahead / max(0.5, 1 - piece.curvature * side)
        ahead_piece, _ = self._find_piece(progress + preview)
        return Place(progress, side, wrap_angle(pose.heading - there.heading), ahead_piece.curvature)

    def _find_piece(self, progress: float) -> tuple[Piece, float]:
        begin = 0.0
        for piece in self.pieces[:-1]:
            if abs(progress) < abs(begin + piece.length):
                return piece, begin
            begin += piece.length
        return self.pieces[-1], begin
