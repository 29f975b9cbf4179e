"""The cameras of one simulation, which share a renderer."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drivers.mujoco.body import Body
from drivers.mujoco.camera import MujocoCamera
from drivers.mujoco.model.world import seen_name
from drivers.mujoco.opengl import NoOpenGL
from drivers.mujoco.rendering import Renderer
from robotcore.description import CameraDescription, WorldDescription
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock

if TYPE_CHECKING:
    from mujoco import MjData, MjModel


class Eyes:
    """Opens cameras. The first brings OpenGL along: a robot that opens none needs none."""

    def __init__(self, model: MjModel, data: MjData, world: WorldDescription) -> None:
        self._model, self._data, self._sky = model, data, world.light.sky_colour
        self._things = {thing.name: model.geom(seen_name(thing.name)).id for thing in (*world.prisms, *world.targets)}
        self._renderer: Renderer | None = None

    def open(self, told: CameraDescription, clock: Clock, body: Body) -> MujocoCamera:
        """Open a camera; raises DeviceError, with what to install, where there is no OpenGL without a screen."""
        try:
            self._renderer = self._renderer or Renderer(self._model, self._data, self._sky)
        except NoOpenGL as missing:
            raise DeviceError(told.name, str(missing)) from missing
        return MujocoCamera(told, clock, body, self._renderer, self._things)

    def close(self) -> None:
        """Let OpenGL go. May be called again."""
        if self._renderer:
            self._renderer.close()
