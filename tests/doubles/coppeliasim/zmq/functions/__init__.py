"""The ``sim`` functions that the double has. One that is missing here is refused by name, never answered."""

from tests.doubles.coppeliasim.zmq.functions import (  # noqa: F401  each registers its functions
    building,
    files,
    groups,
    joints,
    kept,
    lamps,
    objects,
    parameters,
    places,
    properties,
    proximity,
    scripts,
    shapes,
    simulation,
    touching,
    vision,
)
from tests.doubles.coppeliasim.zmq.functions.registry import FUNCTIONS

__all__ = ["FUNCTIONS"]
