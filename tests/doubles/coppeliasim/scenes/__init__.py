"""Scenes that are built in code."""

from tests.doubles.coppeliasim.scenes.described import described_scene
from tests.doubles.coppeliasim.scenes.parts import default_scene, rover_scene
from tests.doubles.coppeliasim.scenes.tutorials import bubblerob_scene, relay_scene

__all__ = ["bubblerob_scene", "default_scene", "described_scene", "relay_scene", "rover_scene"]
