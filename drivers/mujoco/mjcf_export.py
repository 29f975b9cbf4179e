"""Export of the model as MJCF, the format of MuJoCo's own tools.

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
"""The drawn size of a sensor's site, in metres."""


def mjcf(robot: RobotDescription, world: WorldDescription | None, folder: str | None) -> ModelExport:
    """Return the simulated model as MJCF. MuJoCo writes the numbers of the model with six digits.

    Each sensor has an additional site ``<sensor>_frame``. The sensor points along the site's x axis.

    robot: the robot, which is placed at the world's start pose.
    world: the world; None exports the robot alone.
    folder: the folder of the textures, relative to the MJCF file. With None, the model has no textures, and a
        note reports this.

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
    """Remove textures from a model. Return a note about them, or none if there are no textures."""
    names = [texture.name for texture in textures]
    for material in spec.materials:
        for role, name in enumerate(material.textures):
            if name in names:
                material.textures[role] = ""
    for texture in textures:
        spec.delete(texture)
    left_out = f"{pluralize(len(names), 'texture')} left out: textures need files. Name the file with --output"
    return (left_out,) if names else ()


def _encode_png(texture: MjsTexture) -> bytes:
    tile = np.frombuffer(texture.data, np.uint8).reshape(texture.height, texture.width, texture.nchannel)
    return cv2.imencode(".png", tile[:, :, ::-1])[1].tobytes()
