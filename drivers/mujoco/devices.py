"""The devices of a robot in a MuJoCo simulation: motors, encoders, range sensors and cameras."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from drivers.mujoco.model.attributes import RANGE_GROUPS, group_flags
from drivers.mujoco.model.world import visual_name
from drivers.mujoco.opengl import NoOpenGL
from drivers.mujoco.physics import Array, Body
from drivers.mujoco.rendering import ObjectIds, Renderer
from robotcore.description import (
    CameraDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    WorldDescription,
)
from robotcore.errors import DeviceError
from robotcore.geometry import Pose
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Angle, Camera, Encoder, Frame, Image, Motor, Range, RangeSensor
from robotcore.optics import CameraView
from robotcore.raycast import FAN_RAYS, FAN_SETBACK_M, Fan
from robotcore.simulation.sampling import SampleCache

if TYPE_CHECKING:
    from mujoco import MjData, MjModel


class MujocoMotor(Motor):
    """A motor of a wheel. This class only sets the velocity. MuJoCo simulates the lag and the torque limit."""

    def __init__(self, model: MjModel, data: MjData, description: MotorDescription, body: Body) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        body.find_joint(self.name)
        self._controls, self._number = data.ctrl, model.actuator(self.name).id

    def _apply(self, rad_s: float) -> None:
        self._controls[self._number] = rad_s


class MujocoEncoder(Encoder):
    """An encoder of a wheel. It measures the angle of the wheel's joint in whole counts."""

    def __init__(self, description: EncoderDescription, clock: Clock, body: Body) -> None:
        super().__init__(description.name)
        self._description, self._body = description, body
        self._joint = body.find_joint(self.name)
        self._cache = SampleCache(clock, self._measure)

    def _newest(self) -> Angle:
        return self._cache()

    def _measure(self, time: float, sequence: int) -> Angle:
        return Angle(self._description.quantise(self._body.angle(self._joint)), time, sequence)


class MujocoRangeSensor(RangeSensor):
    """A range sensor that casts a fan of rays. The rays ignore the robot and the floor."""

    def __init__(
        self, model: MjModel, data: MjData, description: RangeSensorDescription, clock: Clock, body: Body
    ) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)
        self._model, self._data, self._body = model, data, body
        self._fan = Fan(cone=description.cone_rad, **limits)
        self._origin, self._rays = self._fan.rays(description.mount)
        self._groups = np.array(group_flags(RANGE_GROUPS), dtype=np.uint8)
        self._hit, self._lengths = np.zeros(FAN_RAYS, dtype=np.int32), np.zeros(FAN_RAYS)
        self._cache = SampleCache(clock, self._measure)

    def _newest(self) -> Range:
        return self._cache()

    def _measure(self, time: float, sequence: int) -> Range:
        lengths = self._cast()
        return Range(self._fan.reading(lengths), time, sequence, self._fan.point(lengths))

    def _cast(self) -> Array:
        """Return the length of each ray of the fan in metres; ``inf`` for a ray that hits nothing."""
        from mujoco import mj_multiRay

        rotation, origin = self._body.transform()
        start, rays = origin + rotation @ self._origin, (self._rays @ rotation.T).ravel()
        reach = self.max_range + 2 * FAN_SETBACK_M
        into = (self._hit, self._lengths, None)
        mj_multiRay(self._model, self._data, start, rays, self._groups, True, -1, *into, FAN_RAYS, reach)
        return np.where(self._hit >= 0, self._lengths, math.inf)


class MujocoCamera(Camera):
    """A camera on the robot's body."""

    def __init__(
        self, description: CameraDescription, clock: Clock, body: Body, renderer: Renderer, things: Mapping[str, int]
    ) -> None:
        """Create the camera.

        things: the id of each thing in `segmentation`, by the name of the thing.
        """
        super().__init__(description.name, description.intrinsics)
        self.things = things
        self._body, self._renderer = body, renderer
        self._on_body = CameraView.of(self.intrinsics, description.mount, Pose(0.0, 0.0, 0.0))
        self._cache = SampleCache(clock, self._capture)

    def picture(self, view: CameraView) -> Image:
        """Render a picture of the world, of shape (height, width, 3), in BGR and read-only.

        view: the pose and the optics to render with, in place of this camera's own.
        """
        try:
            image = self._renderer.picture(view)
        except NoOpenGL as error:
            raise DeviceError(self.name, str(error), kind="no-opengl") from error
        image.flags.writeable = False
        return image

    def segmentation(self, view: CameraView) -> ObjectIds:
        """Return the id of the object at each pixel of a view, of shape (height, width); -1 for the sky."""
        return self._renderer.segmentation(view)

    def _newest(self) -> Frame:
        return self._cache()

    def _capture(self, time: float, sequence: int) -> Frame:
        return Frame(self.picture(self._view()), time, sequence)

    def _view(self) -> CameraView:
        rotation, origin = self._body.transform()
        local = self._on_body
        return CameraView(self.intrinsics, origin + rotation @ local.eye, local.rotation @ rotation.T)


class CameraSet:
    """Opens the cameras of a robot. The first camera opens OpenGL, so a robot without cameras does not need OpenGL."""

    def __init__(self, model: MjModel, data: MjData, world: WorldDescription) -> None:
        self._model, self._data, self._sky = model, data, world.light.sky_colour
        self._things = {thing.name: model.geom(visual_name(thing.name)).id for thing in (*world.prisms, *world.targets)}
        self._renderer: Renderer | None = None

    def open(self, description: CameraDescription, clock: Clock, body: Body) -> MujocoCamera:
        """Open a camera. Raises DeviceError if no OpenGL library works without a screen."""
        try:
            self._renderer = self._renderer or Renderer(self._model, self._data, self._sky)
        except NoOpenGL as missing:
            raise DeviceError(description.name, str(missing), kind="no-opengl") from missing
        return MujocoCamera(description, clock, body, self._renderer, self._things)

    def close(self) -> None:
        """Release OpenGL. Further calls do nothing."""
        if self._renderer:
            self._renderer.close()
