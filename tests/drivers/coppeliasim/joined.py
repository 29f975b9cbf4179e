"""Robots whose files say where in a scene their devices are."""

from __future__ import annotations

from robotcore.description import DisplayDescription, EncoderDescription, RobotDescription, load_robot


def joined(name: str) -> RobotDescription:
    """Return a robot that is in the scene as the double's described scenes have it: devices by their own names."""
    robot = load_robot(name)
    section = {
        told.name: {
            "path": f"/{name}/{told.name.replace('encoder', 'motor') if isinstance(told, EncoderDescription) else told.name}"
        }
        for told in robot.devices
        if not isinstance(told, DisplayDescription)
    }
    return robot.model_copy(update={"backends": {"coppeliasim": section}})
