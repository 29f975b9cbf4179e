"""Robots and worlds for other tools: URDF, and what the simulators write of their own models."""

from __future__ import annotations

from robotcore.description import RobotDescription, WorldDescription, draw_world, load_world, require_start
from robotcore.description.urdf import robot_urdf
from robotcore.errors import UnknownNameError
from robotcore.hal.backend import Exported, loadable_backends

URDF = "urdf"


def prepare_world(robot: RobotDescription, world: str, seed: int | None) -> tuple[RobotDescription, WorldDescription]:
    """Return a robot and a world, by its name or from its file, as they are simulated.

    With a seed the world is the one that the seed draws for this robot, else it stands as its file has it.
    Raises DescriptionError where the robot has no room in it.
    """
    described = load_world(world)
    if seed is None:
        require_start(described, robot)
    else:
        described = draw_world(described, robot, seed)
    return robot.with_conditions(described.conditions), described


def export_model(
    file_format: str, robot: RobotDescription, world: WorldDescription | None = None, folder: str | None = None
) -> Exported:
    """Return the model of a robot in a format, at the start of a world if there is one.

    ``folder`` is the name of one beside the file, for the pictures that the model shows; with None they are left out.
    Raises UnknownNameError, or BackendMissingError where the simulator that writes the format is not installed.
    """
    if file_format == URDF:
        return Exported(robot_urdf(robot, world), notes=_plain(world))
    exporters = {name: backend for backend in loadable_backends() for name in backend.exports}
    if file_format not in exporters:
        raise UnknownNameError("format", file_format, [URDF, *exporters])
    return exporters[file_format].export(file_format, robot, world, folder)


def _plain(world: WorldDescription | None) -> tuple[str, ...]:
    """Return the note that patterns are left out, where a world has any."""
    surfaces = (world.floor, *world.prisms) if world else ()
    is_patterned = any(surface.texture for surface in surfaces)
    return ("URDF knows no patterns: each surface has its one colour",) if is_patterned else ()
