"""Exports robots and worlds for other tools, as URDF or in a simulator's format."""

from __future__ import annotations

from robotcore.description import RobotDescription, WorldDescription, draw_world, load_world, require_start
from robotcore.description.urdf import robot_urdf
from robotcore.errors import UnknownNameError
from robotcore.hal.backend import ModelExport, loadable_backends

URDF = "urdf"


def prepare_world(robot: RobotDescription, world: str, seed: int | None) -> tuple[RobotDescription, WorldDescription]:
    """Return a robot and a world with the layout and the conditions of a simulated run.

    robot: the robot.
    world: the name or the file of the world.
    seed: the seed that draws the world's layout; None for the layout of the file.

    Raises DescriptionError if the robot has no room in the world.
    """
    described = load_world(world)
    if seed is None:
        require_start(described, robot)
    else:
        described = draw_world(described, robot, seed)
    return robot.with_conditions(described.conditions), described


def export_model(
    file_format: str, robot: RobotDescription, world: WorldDescription | None = None, folder: str | None = None
) -> ModelExport:
    """Return the model of a robot, and of a world around it, in a format.

    file_format: ``urdf``, or a format of a simulator.
    robot: the robot.
    world: the world, with the robot at its start. With None, the robot is exported alone.
    folder: the name of the folder, beside the document, for the pictures of textures. With None there are no pictures.

    Raises UnknownNameError for an unknown format, and BackendMissingError if the format's simulator is not installed.
    """
    if file_format == URDF:
        return ModelExport(robot_urdf(robot, world), notes=_plain(world))
    exporters = {name: backend for backend in loadable_backends() for name in backend.exports}
    if file_format not in exporters:
        raise UnknownNameError("format", file_format, [URDF, *exporters])
    return exporters[file_format].export(file_format, robot, world, folder)


def _plain(world: WorldDescription | None) -> tuple[str, ...]:
    """Return a note for the user if the world has patterns, because URDF cannot express them."""
    surfaces = (world.floor, *world.prisms) if world else ()
    is_patterned = any(surface.texture for surface in surfaces)
    return ("URDF has no patterns: each surface has one colour",) if is_patterned else ()
