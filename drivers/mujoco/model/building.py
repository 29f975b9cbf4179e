"""A robot and a world, in one model."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drivers.mujoco.model.robot import add_robot
from drivers.mujoco.model.world import add_world
from robotcore.description import RobotDescription, WorldDescription

if TYPE_CHECKING:
    from mujoco import MjSpec

NEAR_M, FAR_M = 0.005, 500.0


def build(robot: RobotDescription | None, world: WorldDescription | None, step: float | None = None) -> MjSpec:
    """Return the model of a robot at a world's start, of either alone too; ``step`` is the physics step in seconds."""
    import mujoco

    spec = mujoco.MjSpec()
    spec.modelname = " in ".join(each.name for each in (robot, world) if each)
    spec.compiler.degree = False
    _set_options(spec, step)
    if world:
        add_world(spec, world)
    if robot:
        add_robot(spec, robot, world.start.pose if world else None)
    return spec


def _set_options(spec: MjSpec, step: float | None) -> None:
    """Set what wheels need to roll as they are told; the figures are in QUALITY.md."""
    import mujoco

    option = spec.option
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10
    if step:
        option.timestep = step
    spec.stat.extent = 1.0  # the planes of the view are counted in it
    spec.visual.map.znear, spec.visual.map.zfar = NEAR_M, FAR_M
    spec.visual.quality.shadowsize = 0
    spec.visual.quality.offsamples = 0
