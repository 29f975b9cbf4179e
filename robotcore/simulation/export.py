"""Export robots and worlds for other tools, as URDF or in a simulator's format."""

from __future__ import annotations

from robotcore.description import RobotDescription, WorldDescription, draw_world, load_world, require_start
from robotcore.description.urdf import build_robot_urdf
from robotcore.errors import UnknownNameError
from robotcore.hal.backend import ModelExport, loadable_backends

URDF = "urdf"


def prepare_world(robot: RobotDescription, world: str, seed: int | None) -> tuple[RobotDescription, WorldDescription]:
    """Return the robot and the world of a simulated run.

    The result has the layout that the seed draws. The robot has the wheel lag that the world sets, if any.

    world: the name or the file of the world.
    seed: the seed from which the world's layout is drawn; None for the layout in the file.

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
    world: the world with the robot at its start pose; None for the robot alone.
    folder: the name of the folder for the pictures of textures, next to the exported file; None for no pictures.

    Raises UnknownNameError for an unknown format, and BackendMissingError if the format's simulator is not installed.
    """
    if file_format == URDF:
        return ModelExport(build_robot_urdf(robot, world), notes=_list_urdf_notes(world))
    exporters = {name: backend for backend in loadable_backends() for name in backend.exports}
    if file_format not in exporters:
        raise UnknownNameError("format", file_format, [URDF, *exporters])
    return exporters[file_format].export(file_format, robot, world, folder)


def _list_urdf_notes(world: WorldDescription | None) -> tuple[str, ...]:
    if world is None:
        return ()
    surfaces = (world.floor, *world.prisms)
    is_patterned = any(surface.texture for surface in surfaces) or world.floor.image or world.lines
    return ("URDF has no patterns, lines or pictures: each surface has one colour",) if is_patterned else ()
