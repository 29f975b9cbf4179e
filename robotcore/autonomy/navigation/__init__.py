"""Navigation with a range sensor, a camera and odometry: mapping, exploration and path planning."""

from robotcore.autonomy.navigation.ball import BallTracker
from robotcore.autonomy.navigation.navigator import Navigator
from robotcore.autonomy.navigation.occupancy_grid import OccupancyGrid
from robotcore.autonomy.navigation.planner import StopPoint
from robotcore.autonomy.navigation.routines import FACING_RAD, drive_to, explore, turn_to

__all__ = ["FACING_RAD", "BallTracker", "Navigator", "OccupancyGrid", "StopPoint", "drive_to", "explore", "turn_to"]
