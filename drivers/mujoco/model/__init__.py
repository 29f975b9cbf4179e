"""The descriptions as a MuJoCo model."""

from drivers.mujoco.model.building import build, compiled

__all__ = ["build", "compiled"]
