"""The camera, the encoder and the range sensor. Each measures only when it is read."""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from drivers.pybullet.body import Body
from drivers.pybullet.bullet import Bullet
from drivers.pybullet.scene import Scene
from robotcore.description import CameraDescription, EncoderDescription, RangeSensorDescription
from robotcore.geometry import Pose
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Angle, Camera, Encoder, Frame, Image, Range, RangeSensor
from robotcore.optics import CameraView
from robotcore.raycast import FAN_SETBACK_M, Fan
from robotcore.simulation.sampling import SampleCache


class BulletEncoder(Encoder):
    """Whole counts of a wheel's joint."""

    def __init__(self, bullet: Bullet, description: EncoderDescription, clock: Clock, body: Body) -> None:
        super().__init__(description.name)
        self._description = description
        self._joint_state = bullet.getJointState
        self._body, self._joint = body.number, body.joint_of(self.name)
        self._newest_at = SampleCache(clock, self._count)

    def _newest(self) -> Angle:
        return self._newest_at()

    def _count(self, time: float, sequence: int) -> Angle:
        angle = self._joint_state(self._body, self._joint)[0]
        return Angle(self._description.quantise(angle), time, sequence)


class BulletRangeSensor(RangeSensor):
    """The fan of rays. It meets things only: robot and floor are in no group that rays collide with."""

    def __init__(self, bullet: Bullet, description: RangeSensorDescription, clock: Clock, body: Body) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)
        self._fan = Fan(cone=description.cone_rad, **limits)
        self._length = self.max_range + 2 * FAN_SETBACK_M
        self._origin, directions = self._fan.rays(description.mount)
        self._rays = directions * self._length
        self._cast = bullet.rayTestBatch
        self._body = body
        self._newest_at = SampleCache(clock, self._listen)

    def _newest(self) -> Range:
        return self._newest_at()

    def _listen(self, time: float, sequence: int) -> Range:
        rotation, origin = self._body.transform()
        start = origin + rotation @ self._origin
        ends = start + self._rays @ rotation.T
        hits = self._cast([start] * len(ends), ends)
        lengths = np.array([hit[2] * self._length if hit[0] >= 0 else math.inf for hit in hits])
        return Range(self._fan.reading(lengths), time, sequence, self._fan.point(lengths))


NEAR_M, FAR_M = 0.005, 500.0


Numbers = NDArray[np.int32]


class BulletCamera(Camera):
    """A camera on the robot's body; it tilts with it. ``things`` maps names to the `numbers` of a picture's pixels."""

    def __init__(self, bullet: Bullet, description: CameraDescription, clock: Clock, body: Body, scene: Scene) -> None:
        super().__init__(description.name, description.intrinsics)
        self._bullet = bullet
        self._body = body
        self._light = scene.light
        self.things = scene.things
        self._on_body = CameraView.of(self.intrinsics, description.mount, Pose(0.0, 0.0, 0.0))
        self._newest_at = SampleCache(clock, self._expose)

    def picture(self, view: CameraView) -> Image:
        """Render what any camera would see; works without the robot being there. BGR, read-only."""
        rgba, numbers = self._render(view)
        image: Image = np.asarray(cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGR), dtype=np.uint8)
        sky = _plain_image(self._light.sky_colour[::-1], *numbers.shape)
        cv2.copyTo(sky, (numbers < 0).view(np.uint8), image)  # a boolean index takes ten times as long
        image.flags.writeable = False
        return image

    def numbers(self, view: CameraView) -> Numbers:
        """Return which thing each pixel of such a picture shows, (height, width), by its number; -1: sky."""
        return self._render(view)[1]

    def _newest(self) -> Frame:
        return self._newest_at()

    def _expose(self, time: float, sequence: int) -> Frame:
        return Frame(self.picture(self._view()), time, sequence)

    def _render(self, view: CameraView) -> tuple[Image, Numbers]:
        """Return what a camera would see: RGBA, and numbers."""
        size, light = view.intrinsics, self._light
        _, _, rgba, _, numbers = self._bullet.getCameraImage(
            size.width,
            size.height,
            viewMatrix=_view_matrix(view),
            projectionMatrix=self._projection_matrix(view),
            lightDirection=light.direction,
            lightColor=(1.0, 1.0, 1.0),
            lightAmbientCoeff=light.ambient * light.brightness,
            lightDiffuseCoeff=light.diffuse * light.brightness,
            lightSpecularCoeff=0.0,
            shadow=0,
            renderer=self._bullet.ER_TINY_RENDERER,
        )
        return rgba, numbers

    def _view(self) -> CameraView:
        rotation, origin = self._body.transform()
        local = self._on_body
        return CameraView(self.intrinsics, origin + rotation @ local.eye, local.rotation @ rotation.T)

    def _projection_matrix(self, view: CameraView) -> list[float]:
        """Return the pinhole's frustum, moved by half a pixel: Bullet samples a pixel at its lower left corner."""
        size = view.intrinsics
        pixel = NEAR_M / size.focal_length
        right, top = size.width / 2 * pixel, size.height / 2 * pixel
        edges = (pixel / 2 - right, pixel / 2 + right, pixel / 2 - top, pixel / 2 + top)
        matrix: list[float] = self._bullet.computeProjectionMatrix(*edges, NEAR_M, FAR_M)
        return matrix


@lru_cache(maxsize=8)
def _plain_image(colour: tuple[int, ...], height: int, width: int) -> Image:
    """Return a picture of one BGR colour; making it takes longer than all else that comes after the rendering."""
    return np.full((height, width, 3), colour, dtype=np.uint8)


def _view_matrix(view: CameraView) -> list[float]:
    """Return OpenGL's view matrix, column by column: right, up and back of the eye."""
    matrix = np.eye(4)
    matrix[:3, :3] = view.rotation * ((1.0,), (-1.0,), (-1.0,))
    matrix[:3, 3] = -matrix[:3, :3] @ view.eye
    flat: list[float] = matrix.T.ravel().tolist()
    return flat
