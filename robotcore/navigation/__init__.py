"""Finding one's way with a range sensor and odometry: a map as it is seen, and paths through it."""

from robotcore.navigation.grid import OccupancyGrid
from robotcore.navigation.navigator import Navigator

__all__ = ["Navigator", "OccupancyGrid"]
