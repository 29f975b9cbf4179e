"""The descriptions as a MuJoCo model."""

from drivers.mujoco.model.building import build

__all__ = ["build"]
