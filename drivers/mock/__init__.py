"""The mock backend: scripted readings, recorded commands, and a clock that the test steps.

Tests of apps take it from `robotcore.testing`.
"""

from robotcore.testing.mock.backend import MockBackend
from robotcore.testing.mock.devices import LOST
from robotcore.testing.mock.robot import MockRobot

__all__ = ["LOST", "MockBackend", "MockRobot"]
