"""The camera, the encoder and the range sensor in Bullet. Each measures only if the app reads it."""

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
    """An encoder of a wheel. It measures the angle of the wheel's joint in whole counts."""

    def __init__(self, bullet: Bullet, description: EncoderDescription, clock: Clock, body: Body) -> None:
        super().__init__(description.name)
        self._description = description
        self._joint_state = bullet.getJointState
        self._body, self._joint = body.body_id, body.find_joint(self.name)
        self._cache = SampleCache(clock, self._measure)

    def _newest(self) -> Angle:
        return self._cache()

    def _measure(self, time: float, sequence: int) -> Angle:
        angle = self._joint_state(self._body, self._joint)[0]
        return Angle(self._description.quantise(angle), time, sequence)


class BulletRangeSensor(RangeSensor):
    """A range sensor that casts a fan of rays. The rays ignore the robot and the floor."""

    def __init__(self, bullet: Bullet, description: RangeSensorDescription, clock: Clock, body: Body) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)
        self._fan = Fan(cone=description.cone_rad, **limits)
        self._length = self.max_range + 2 * FAN_SETBACK_M
        self._origin, directions = self._fan.rays(description.mount)
        self._rays = directions * self._length
        self._cast = bullet.rayTestBatch
        self._body = body
        self._cache = SampleCache(clock, self._measure)

    def _newest(self) -> Range:
        return self._cache()

    def _measure(self, time: float, sequence: int) -> Range:
        rotation, origin = self._body.transform()
        start = origin + rotation @ self._origin
        ends = start + self._rays @ rotation.T
        hits = self._cast([start] * len(ends), ends)
        lengths = np.array([hit[2] * self._length if hit[0] >= 0 else math.inf for hit in hits])
        return Range(self._fan.reading(lengths), time, sequence, self._fan.point(lengths))


NEAR_M, FAR_M = 0.005, 500.0
"""The distances of the near and the far clipping plane of a camera, in metres."""

ObjectIds = NDArray[np.int32]


class BulletCamera(Camera):
    """A camera on the robot's body."""

    def __init__(self, bullet: Bullet, description: CameraDescription, clock: Clock, body: Body, scene: Scene) -> None:
        super().__init__(description.name, description.intrinsics)
        self._bullet = bullet
        self._body = body
        self._light = scene.light
        self.things = scene.things
        """The ids of the things in `segmentation`, by the name of the thing."""
        self._on_body = CameraView.of(self.intrinsics, description.mount, Pose(0.0, 0.0, 0.0))
        self._cache = SampleCache(clock, self._capture)

    def picture(self, view: CameraView) -> Image:
        """Render a picture of the world, of shape (height, width, 3), in BGR and read-only.

        view: the pose and the optics to render with, in place of this camera's own.
        """
        rgba, ids = self._render(view)
        image: Image = np.asarray(cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGR), dtype=np.uint8)
        sky = _plain_image(self._light.sky_colour[::-1], *ids.shape)
        cv2.copyTo(sky, (ids < 0).view(np.uint8), image)  # a boolean index takes ten times as long
        image.flags.writeable = False
        return image

    def segmentation(self, view: CameraView) -> ObjectIds:
        """Return the id of the object at each pixel of a view, of shape (height, width); -1 for the sky."""
        return self._render(view)[1]

    def _newest(self) -> Frame:
        return self._cache()

    def _capture(self, time: float, sequence: int) -> Frame:
        return Frame(self.picture(self._view()), time, sequence)

    def _render(self, view: CameraView) -> tuple[Image, ObjectIds]:
        size, light = view.intrinsics, self._light
        _, _, rgba, _, ids = self._bullet.getCameraImage(
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
        return rgba, ids

    def _view(self) -> CameraView:
        rotation, origin = self._body.transform()
        local = self._on_body
        return CameraView(self.intrinsics, origin + rotation @ local.eye, local.rotation @ rotation.T)

    def _projection_matrix(self, view: CameraView) -> list[float]:
        """Return the projection matrix of a pinhole camera, moved by half a pixel.

        Bullet samples a pixel at its lower left corner, not at its centre.
        """
        size = view.intrinsics
        pixel = NEAR_M / size.focal_length
        right, top = size.width / 2 * pixel, size.height / 2 * pixel
        edges = (pixel / 2 - right, pixel / 2 + right, pixel / 2 - top, pixel / 2 + top)
        matrix: list[float] = self._bullet.computeProjectionMatrix(*edges, NEAR_M, FAR_M)
        return matrix


@lru_cache(maxsize=8)
def _plain_image(colour: tuple[int, ...], height: int, width: int) -> Image:
    """Return a picture of one BGR colour. The result is cached, because creating it is slow."""
    return np.full((height, width, 3), colour, dtype=np.uint8)


def _view_matrix(view: CameraView) -> list[float]:
    """Return OpenGL's view matrix, column by column. Its rows are the camera's right, up and backward axes."""
    matrix = np.eye(4)
    matrix[:3, :3] = view.rotation * ((1.0,), (-1.0,), (-1.0,))
    matrix[:3, 3] = -matrix[:3, :3] @ view.eye
    flat: list[float] = matrix.T.ravel().tolist()
    return flat
