"""Finding one's way with a range sensor, a camera and odometry: a map as it is seen, and paths through it."""

from robotcore.navigation.ball import BallTracker
from robotcore.navigation.grid import OccupancyGrid
from robotcore.navigation.navigator import Navigator
from robotcore.navigation.targets import Target

__all__ = ["BallTracker", "Navigator", "OccupancyGrid", "Target"]
