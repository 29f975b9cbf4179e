"""Builds a MuJoCo model from the descriptions of a robot and a world."""

from drivers.mujoco.model.builder import build, compile_model

__all__ = ["build", "compile_model"]
