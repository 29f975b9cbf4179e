"""The ``sim`` functions that the double has. It refuses a function that is missing here by its name."""

from tests.doubles.coppeliasim.zmq.functions import bodies, building, objects, parameters, sensors, simulation  # noqa: F401  each registers its functions
from tests.doubles.coppeliasim.zmq.functions.registry import FUNCTIONS

__all__ = ["FUNCTIONS"]
