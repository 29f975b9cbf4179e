"""Robots whose files say where in a scene their devices are."""

from __future__ import annotations

from robotcore.description import DisplayDescription, RobotDescription, load_robot


def joined(name: str) -> RobotDescription:
    """Return a robot that is in the scene as the double's described scenes have it: devices by their own names."""
    robot = load_robot(name)
    devices = [told.name for told in robot.devices if not isinstance(told, DisplayDescription)]
    section = {device: {"path": f"/{name}/{device.replace('encoder', 'motor')}"} for device in devices}
    return robot.model_copy(update={"backends": {"coppeliasim": section}})
