"""A robot for unit tests of apps: scripted readings, commands kept, a clock that the test steps."""

from drivers.mock.robot import MockRobot
from drivers.mock.script import LOST

__all__ = ["LOST", "MockRobot"]
