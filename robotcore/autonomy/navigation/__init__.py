"""Finding one's way with a range sensor, a camera and odometry: a map as it is seen, and paths through it."""

from robotcore.autonomy.navigation.ball import BallTracker
from robotcore.autonomy.navigation.navigator import Navigator
from robotcore.autonomy.navigation.occupancy_grid import OccupancyGrid
from robotcore.autonomy.navigation.planner import Target

__all__ = ["BallTracker", "Navigator", "OccupancyGrid", "Target"]
