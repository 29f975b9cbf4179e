"""The simulated world without a protocol: objects, time, a kinematic robot, and sensors."""

from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import NoObjectError, SceneError
from tests.doubles.coppeliasim.scene.simulator import Simulator, State, Ticket

__all__ = ["Graph", "NoObjectError", "SceneError", "Simulator", "State", "Ticket"]
