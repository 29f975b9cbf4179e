"""The camera: MuJoCo's OpenGL renderer, seen as a pinhole camera sees."""

from __future__ import annotations

import cv2
import numpy as np

from drivers.mujoco.rendering import Renderers
from robotcore.clock import Clock
from robotcore.description import CameraDescription
from robotcore.devices import Camera, Frame
from robotcore.sampling import OnceAnInstant


class MujocoCamera(Camera):
    """A camera on the robot's body; it tilts with it. Nothing is rendered unless it is read."""

    def __init__(self, description: CameraDescription, clock: Clock, renderers: Renderers) -> None:
        super().__init__(description.name, description.intrinsics)
        self._renderers = renderers
        renderers.of(self.name, self.intrinsics)
        self._newest_at = OnceAnInstant(clock, self._expose)

    def _newest(self) -> Frame:
        return self._newest_at()

    def _expose(self, time: float, sequence: int) -> Frame:
        rgb = self._renderers.picture(self.name, self.intrinsics)
        image = np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), dtype=np.uint8)
        image.flags.writeable = False
        return Frame(image, time, sequence)
