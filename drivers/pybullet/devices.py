"""The devices of a robot in Bullet. A sensor measures only if the app reads it."""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np

from drivers.pybullet.body import Body
from drivers.pybullet.bullet import Bullet
from robotcore.description import AckermannDrive, Light
from robotcore.description.urdf import STEERING_TORQUE_NM
from robotcore.hal.clock import Clock
from robotcore.hal.joint import Joint
from robotcore.kinds.encoder import EncoderDescription, SimulatedEncoder
from robotcore.kinds.motor import Motor, MotorDescription
from robotcore.optics import CameraView, Image
from robotcore.simulation.rigid_body import Array, ObjectIds


class BulletMotor(Motor):
    """A motor. The velocity of its wheel's joint follows the command with a first-order lag.

    In a step of h seconds, a lag τ reduces the difference between velocity and command by the fraction 1 - exp(-h/τ).
    The wheels of a motor with a differential gear turn at the velocities at which they roll along the steered path.
    """

    def __init__(
        self, bullet: Bullet, description: MotorDescription, body: Body, step: float, steering: Steering | None = None
    ) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._control = bullet.setJointMotorControl2
        self._body, self._joints = body.body_id, body.find_joints(self.name)
        self._steering = steering if len(self._joints) > 1 else None
        self._velocity_control = bullet.VELOCITY_CONTROL
        self._torque = description.max_torque_nm / len(self._joints)
        self._gain = -math.expm1(-step / description.lag_s) if description.lag_s else 1.0
        self._respond, self._command, self._velocity = description.respond, 0.0, 0.0
        self._targets: tuple[float, ...] = ()
        self.drive()

    def drive(self) -> None:
        """Set the target velocity of each joint for the next physics step."""
        before = self._targets
        self._velocity += (self._command - self._velocity) * self._gain
        ratios = self._steering.ratios if self._steering else (1.0,) * len(self._joints)
        self._targets = tuple(self._velocity * ratio for ratio in ratios)
        if self._targets != before:
            self._send()

    def _apply(self, rad_s: float) -> None:
        self._command = self._respond(rad_s)

    def _send(self) -> None:
        for joint, target in zip(self._joints, self._targets, strict=True):
            self._control(self._body, joint, self._velocity_control, targetVelocity=target, force=self._torque)


class Steering:
    """The front wheels of a drive that steers. They follow the joint of its servo, and roll freely."""

    def __init__(self, bullet: Bullet, body: Body, drive: AckermannDrive, joint: Joint, step: float) -> None:
        self._body, self._joints = body.body_id, body.find_steering_joints()
        self._joint_state, self._control = bullet.getJointState, bullet.setJointMotorControl2
        self._velocity_control = bullet.VELOCITY_CONTROL
        self._drive, self._joint, self._step = drive, joint, step
        self.ratios = (1.0, 1.0)
        """The velocities of the left and the right rear wheel, divided by the mean of both."""

    def turn(self, time: float) -> None:
        """Let the next physics step turn the wheels to the servo's angle at a time in seconds."""
        angle = self._joint.angle_at(time)
        half = self._drive.to_curvature(angle) * self._drive.track_m / 2
        self.ratios = (1 - half, 1 + half)
        for joint, target in zip(self._joints, self._drive.to_wheel_angles_rad(angle), strict=True):
            velocity = (target - self._joint_state(self._body, joint)[0]) / self._step
            self._control(self._body, joint, self._velocity_control, targetVelocity=velocity, force=STEERING_TORQUE_NM)


def open_encoder(description: EncoderDescription, clock: Clock, body: Body) -> SimulatedEncoder:
    """Open the encoder of a wheel. Raises DeviceError if the encoder is on no wheel."""
    joints = body.find_joints(description.name)
    return SimulatedEncoder(description, clock, lambda: body.angle(joints))


def cast_rays(bullet: Bullet, start: Array, rays: Array, length_m: float) -> Array:
    """Return the length of each ray up to its first hit, (n,) in metres. The rays ignore the robot and the floor.

    start: the common start of the rays in the world, (3,) in metres.
    rays: the rays, (n, 3) in metres, all of the length ``length_m``.
    """
    hits = bullet.rayTestBatch([start] * len(rays), start + rays)
    return np.array([hit[2] * length_m if hit[0] >= 0 else math.inf for hit in hits])


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
