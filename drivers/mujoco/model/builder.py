"""Builds one model of a robot and a world."""

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


STEP_S = 1 / MIN_PHYSICS_RATE_HZ


def build(robot: RobotDescription | None, world: WorldDescription | None, step: float = STEP_S) -> MjSpec:
    """Return the model of a robot at a world's start, of either alone too; ``step`` is the physics step in seconds.

    The motors' lags are exact at that step and no other.
    """
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


def compile_model(spec: MjSpec) -> MjModel:
    """Compile a model. Raises BackendError if it cannot be simulated, for example with a weightless wheel."""
    try:
        return spec.compile()
    except ValueError as error:
        text = " ".join(str(error).removeprefix("Error: ").split())
        raise BackendError(f"mujoco: {text}. Look at the masses and lengths in the descriptions") from error


def _set_options(spec: MjSpec, step: float) -> None:
    """Set what wheels need to roll as they are told, and how all is drawn.

    Under Euler's integration a motor's lag is exact; an implicit one changes velocities after the wheels' grip is
    solved for. A cone of friction grips alike in every direction; on a pyramid a robot that brakes hard swerves.
    """
    import mujoco

    option = spec.option
    option.timestep = step
    option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.stat.extent = 1.0  # the planes of the view are counted in it
    spec.visual.map.znear, spec.visual.map.zfar = NEAR_M, FAR_M
    spec.visual.quality.shadowsize = 0
    spec.visual.quality.offsamples = 0
