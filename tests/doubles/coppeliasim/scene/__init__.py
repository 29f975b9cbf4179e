"""The simulated world on the server's side: objects, time, a kinematic robot, and what sensors see. No protocol."""

from tests.doubles.coppeliasim.scene.graph import Graph
from tests.doubles.coppeliasim.scene.objects import NoObjectError, SceneError
from tests.doubles.coppeliasim.scene.simulator import Simulator, Ticket
from tests.doubles.coppeliasim.scene.states import State

__all__ = ["Graph", "NoObjectError", "SceneError", "Simulator", "State", "Ticket"]
