"""Export the model of a robot and a world as MJCF, the XML format of MuJoCo's own tools.

Source: https://mujoco.readthedocs.io/en/stable/XMLreference.html.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np

from drivers.mujoco.model import build, compile_model
from drivers.mujoco.model.attributes import mount_orientation
from robotcore.description import RobotDescription, WorldDescription
from robotcore.description.urdf import BASE, sensor_link
from robotcore.hal.backend import ModelExport
from robotcore.text import pluralize

if TYPE_CHECKING:
    from mujoco import MjSpec, MjsTexture


SITE_M = 0.005
"""The size of the site that marks the frame of a sensor, in metres."""


def mjcf(robot: RobotDescription, world: WorldDescription | None, folder: str | None) -> ModelExport:
    """Return the model that the backend simulates as MJCF. MuJoCo writes its numbers with six digits.

    The model has a site ``<sensor>_frame`` for each sensor. The sensor points along the x axis of its site.

    robot: the robot. It is placed at the start pose of the world.
    world: the world. None exports the robot alone.
    folder: the folder for the pictures of textures, relative to the MJCF file. None exports the model without
        textures, and adds a note about them.

    Raises BackendError if MuJoCo cannot compile the model.
    """
    spec = build(robot, world)
    _add_frames(spec, robot)
    textures = [texture for texture in spec.textures if texture.data]
    notes = () if folder is not None else _remove_textures(spec, textures)
    compile_model(spec)
    pictures = {f"{folder}/{texture.name}.png": texture for texture in textures} if folder is not None else {}
    for file, texture in pictures.items():
        texture.file = file
    return ModelExport(spec.to_xml(), {file: _encode_png(texture) for file, texture in pictures.items()}, notes)


def _add_frames(spec: MjSpec, robot: RobotDescription) -> None:
    base = spec.body(BASE)
    for sensor, mount in robot.mounts.items():
        place = [mount.x_m, mount.y_m, mount.z_m]
        base.add_site(name=sensor_link(sensor), pos=place, quat=mount_orientation(mount), size=[SITE_M] * 3)


def _remove_textures(spec: MjSpec, textures: list[MjsTexture]) -> tuple[str, ...]:
    """Remove textures from a model. Return a note about the removed textures, or no note without textures."""
    names = [texture.name for texture in textures]
    for material in spec.materials:
        for role, name in enumerate(material.textures):
            if name in names:
                material.textures[role] = ""
    for texture in textures:
        spec.delete(texture)
    left_out = f"{pluralize(len(names), 'texture')} left out: textures need files. Name the MJCF file with --output"
    return (left_out,) if names else ()


def _encode_png(texture: MjsTexture) -> bytes:
    tile = np.frombuffer(texture.data, np.uint8).reshape(texture.height, texture.width, texture.nchannel)
    return cv2.imencode(".png", tile[:, :, ::-1])[1].tobytes()
