"""Scenes in code."""

from tests.doubles.coppeliasim.scenes.default import fill_default_scene

__all__ = ["fill_default_scene"]
