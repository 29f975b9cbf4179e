"""The devices of a robot in Bullet. A sensor measures only if the app reads it."""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np

from drivers.pybullet.body import Body
from drivers.pybullet.bullet import Bullet
from robotcore.description import Light
from robotcore.hal.clock import Clock
from robotcore.kinds.encoder import EncoderDescription, SimulatedEncoder
from robotcore.kinds.motor import Motor, MotorDescription
from robotcore.kinds.range_sensor import RangeSensorDescription
from robotcore.optics import CameraView, Image
from robotcore.raycast import FAN_SETBACK_M
from robotcore.simulation.rigid_body import Array, Locate, ObjectIds, RayFanSensor


class BulletMotor(Motor):
    """A motor of a wheel. The velocity of the wheel's joint follows the command with a first-order lag.

    In a step of h seconds, a lag τ reduces the difference between velocity and command by the fraction 1 - exp(-h/τ).
    """

    def __init__(self, bullet: Bullet, description: MotorDescription, body: Body, step: float) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._control = bullet.setJointMotorControl2
        self._body, self._joint = body.body_id, body.find_joint(self.name)
        self._velocity_control = bullet.VELOCITY_CONTROL
        self._torque = description.max_torque_nm
        self._gain = -math.expm1(-step / description.lag_s) if description.lag_s else 1.0
        self._command = self._velocity = 0.0
        self._send()

    def drive(self) -> None:
        """Set the target velocity of the joint for the next physics step."""
        before = self._velocity
        self._velocity += (self._command - before) * self._gain
        if self._velocity != before:
            self._send()

    def _apply(self, rad_s: float) -> None:
        self._command = rad_s

    def _send(self) -> None:
        self._control(
            self._body, self._joint, self._velocity_control, targetVelocity=self._velocity, force=self._torque
        )


def open_encoder(bullet: Bullet, description: EncoderDescription, clock: Clock, body: Body) -> SimulatedEncoder:
    """Open the encoder of a wheel. Raises DeviceError if the encoder is on no wheel."""
    joint, joint_state = body.find_joint(description.name), bullet.getJointState
    return SimulatedEncoder(description, clock, lambda: float(joint_state(body.body_id, joint)[0]))


RAY_M = 200.0
"""The length of the rays of `GroundTruth.cast`, in metres: longer than the diagonal of any floor."""


def cast_rays(bullet: Bullet, start: Array, rays: Array, length_m: float) -> Array:
    """Return the length of each ray up to its first hit, (n,) in metres. The rays ignore the robot and the floor.

    start: the common start of the rays in the world, (3,) in metres.
    rays: the rays, (n, 3) in metres, all of the length ``length_m``.
    """
    hits = bullet.rayTestBatch([start] * len(rays), start + rays)
    return np.array([hit[2] * length_m if hit[0] >= 0 else math.inf for hit in hits])


def open_range_sensor(
    bullet: Bullet, description: RangeSensorDescription, clock: Clock, body: Body, locate: Locate
) -> RayFanSensor:
    """Open a range sensor, whose rays ignore the robot and the floor."""
    length = description.max_range_m + 2 * FAN_SETBACK_M

    def cast(start: Array, rays: Array) -> Array:
        return cast_rays(bullet, start, rays, length)

    return RayFanSensor(description, clock, body.transform, locate, cast, length)


NEAR_M, FAR_M = 0.005, 500.0
"""The distances of the near and the far clipping plane of a camera, in metres."""


class BulletRenderer:
    """Renders pictures with Bullet's software renderer."""

    def __init__(self, bullet: Bullet, light: Light) -> None:
        self._bullet, self._light = bullet, light

    def picture(self, view: CameraView) -> Image:
        """Return the picture of a view, (height, width, 3), BGR."""
        rgba, ids = self._render(view)
        image: Image = np.asarray(cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGR), dtype=np.uint8)
        sky = _plain_image(self._light.sky_colour[::-1], *ids.shape)
        cv2.copyTo(sky, (ids < 0).view(np.uint8), image)  # a boolean index takes ten times as long
        return image

    def segmentation(self, view: CameraView) -> ObjectIds:
        """Return the id of the object at each pixel of a view, of shape (height, width); -1 for the sky."""
        return self._render(view)[1]

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
