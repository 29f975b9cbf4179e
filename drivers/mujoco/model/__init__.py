"""The descriptions as a MuJoCo model."""

from drivers.mujoco.model.builder import build, compile_model

__all__ = ["build", "compile_model"]
