"""Build and compile the MuJoCo model of a robot in a world."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drivers.mujoco.model.robot import add_robot
from drivers.mujoco.model.world import add_world
from robotcore.description import RobotDescription, WorldDescription
from robotcore.errors import BackendError
from robotcore.hal.clock import MIN_PHYSICS_RATE_HZ

if TYPE_CHECKING:
    from mujoco import MjModel, MjSpec


NEAR_M, FAR_M = 0.005, 500.0
"""The distances of the near and the far clipping plane of all cameras, in metres."""

STEP_S = 1 / MIN_PHYSICS_RATE_HZ
"""The default length of a physics step, in seconds."""


def build(
    robot: RobotDescription | None, world: WorldDescription | None, step: float = STEP_S, *, has_sheet: bool = True
) -> MjSpec:
    """Return the MuJoCo model of a robot at the start pose of a world, not compiled.

    robot: the robot. None builds a model of the world alone.
    world: the world. None builds a model of the robot alone, at the origin.
    step: the length of a physics step in seconds. The lag of the motors is exact for this length only.
    has_sheet: whether to add the lines and the picture on the floor. Only cameras and windows need them.
    """
    import mujoco

    spec = mujoco.MjSpec()
    spec.modelname = " in ".join(each.name for each in (robot, world) if each)
    spec.compiler.degree = False
    _set_options(spec, step)
    if world:
        add_world(spec, world, has_sheet=has_sheet)
    if robot:
        add_robot(spec, robot, world.start.pose if world else None)
    return spec


def compile_model(spec: MjSpec) -> MjModel:
    """Compile a model. Raises BackendError if MuJoCo refuses the model, for example a wheel without mass."""
    try:
        return spec.compile()
    except ValueError as error:
        text = " ".join(str(error).removeprefix("Error: ").split())
        raise BackendError(f"mujoco: {text}. Check the masses and lengths in the descriptions") from error


def _set_options(spec: MjSpec, step: float) -> None:
    """Set the options of the physics and of the rendering.

    Euler's integrator keeps the lag of the motors exact. An implicit integrator would change velocities after the
    solver has computed the grip of the wheels. The elliptic friction cone grips equally in all directions. With a
    pyramidal cone, a robot that brakes hard would swerve.
    """
    import mujoco

    option = spec.option
    option.timestep = step
    option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.stat.extent = 1.0  # the unit of znear and zfar
    spec.visual.map.znear, spec.visual.map.zfar = NEAR_M, FAR_M
    spec.visual.quality.shadowsize = 0
    spec.visual.quality.offsamples = 0
