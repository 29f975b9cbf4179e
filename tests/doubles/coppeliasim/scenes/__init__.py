"""Scenes in code."""

from tests.doubles.coppeliasim.scenes.bubblerob import bubblerob_scene
from tests.doubles.coppeliasim.scenes.default import default_scene, fill_default_scene
from tests.doubles.coppeliasim.scenes.described import described_scene
from tests.doubles.coppeliasim.scenes.relay import relay_scene

__all__ = ["bubblerob_scene", "default_scene", "described_scene", "fill_default_scene", "relay_scene"]
