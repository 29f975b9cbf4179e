"""A robot for unit tests of apps: scripted readings, commands kept, a clock that the test steps."""

from drivers.mock.devices import LOST
from drivers.mock.robot import MockRobot

__all__ = ["LOST", "MockRobot"]
