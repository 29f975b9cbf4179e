"""The backend ``mock`` for unit tests of apps. Tests import `MockRobot` from `robotcore.testing`."""

from robotcore.testing.mock.backend import MockBackend
from robotcore.testing.mock.devices import LOST
from robotcore.testing.mock.robot import MockRobot

__all__ = ["LOST", "MockBackend", "MockRobot"]
