"""Motors, encoders, range sensors, cameras, displays and the ground truth of a remote scene."""

from __future__ import annotations

import math
from dataclasses import replace
from threading import Lock

import numpy as np

from robotcore.errors import DeviceError
from robotcore.geometry import Pose, Twist
from robotcore.hal.clock import Clock
from robotcore.hal.sampling import SampleCache
from robotcore.kinds.camera import CameraDescription, Render, SimulatedCamera
from robotcore.kinds.display import Display
from robotcore.kinds.encoder import Angle, Encoder, EncoderDescription
from robotcore.kinds.motor import Motor, MotorDescription
from robotcore.kinds.range_sensor import Echo, RangeSensorDescription, SimulatedRangeSensor
from robotcore.optics import Image, Intrinsics
from robotcore.simulation.remote_scene.interface import CameraOptics, Point, RawPicture, Scene


class SceneMotor(Motor):
    """A motor that sets the target velocity of a joint of the scene.

    is_reversed: whether the joint turns backwards as the robot drives forward.
    """

    def __init__(self, description: MotorDescription, scene: Scene, joint: int, *, is_reversed: bool) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._scene, self._joint, self._respond = scene, joint, description.respond
        self._sign = -1.0 if is_reversed else 1.0

    def _apply(self, rad_s: float) -> None:
        velocity = float(self._sign * self._respond(rad_s))  # a remote API encodes no NumPy types
        self._scene.set_joint_velocity(self._joint, velocity)


class SceneEncoder(Encoder):
    """An encoder that measures the angle by which a joint has turned since the robot was opened.

    period: the time between two reads of the joint's angle, in seconds.
    is_reversed: whether the joint turns backwards as the robot drives forward.

    The server reports an angle between -π and π. So the encoder reads it in each period, and adds up the changes. The
    joint must turn by less than half a turn in a period.
    """

    def __init__(
        self,
        description: EncoderDescription,
        scene: Scene,
        joint: int,
        clock: Clock,
        period: float,
        *,
        is_reversed: bool,
    ) -> None:
        super().__init__(description.name)
        self._position = scene.read_joint_position
        self._joint, self._sign = joint, -1.0 if is_reversed else 1.0
        self._quantise = description.quantise
        self._total_rad, self._last_rad = 0.0, self._position(joint)
        self._lock = Lock()
        self._newest_at = SampleCache(clock, self._count)
        self._polling = clock.call_every(period, self._newest, self.name)

    def _newest(self) -> Angle:
        with self._lock:
            return self._newest_at()

    def _count(self, time: float, sequence: int) -> Angle:
        angle_rad = self._position(self._joint)
        self._total_rad += math.remainder(angle_rad - self._last_rad, math.tau)
        self._last_rad = angle_rad
        return Angle(self._quantise(self._sign * self._total_rad), time, sequence)

    def _release(self) -> None:
        self._polling.stop()


class SceneRangeSensor(SimulatedRangeSensor):
    """A range sensor that returns the distance to the point that a proximity sensor of the scene detects.

    The samples do not contain the point itself, because the proximity sensor may be rotated about its own axis.
    """

    def __init__(self, description: RangeSensorDescription, scene: Scene, sensor: int, clock: Clock, seed: int) -> None:
        def measure() -> Echo:
            point = scene.detect(sensor)
            distance = math.inf if point is None else math.hypot(*point)
            is_beyond = distance > description.max_range_m
            return Echo(math.inf if is_beyond else max(distance, description.min_range_m), None)

        super().__init__(description, clock, measure, seed)


SAME_FOV_RAD = math.radians(0.5)
"""The greatest difference, in radians, between two fields of view that count as equal."""


class SceneCamera(SimulatedCamera):
    """A camera that takes its pictures from a vision sensor of the scene."""

    def __init__(
        self,
        description: CameraDescription,
        scene: Scene,
        sensor: int,
        clock: Clock,
        seed: int,
        intrinsics: Intrinsics | None = None,
    ) -> None:
        self._scene, self._sensor = scene, sensor

        def capture(pinhole: Intrinsics) -> Render:
            image = self._take_picture(pinhole)
            return lambda: image

        super().__init__(description, clock, capture, seed, intrinsics)

    def _take_picture(self, expected: Intrinsics) -> Image:
        raw = self._scene.read_picture(self._sensor)
        if (raw.width, raw.height) != (expected.width, expected.height):
            raise DeviceError(
                self.name,
                f"the vision sensor sent a picture of {raw.width}x{raw.height} pixels, expected "
                f"{expected.width}x{expected.height}. Do not change its resolution while the robot is open",
                kind="picture-size",
                width=raw.width,
                height=raw.height,
            )
        return to_opencv(raw)


class SceneDisplay(Display):
    """A display that shows pictures on a vision sensor of the scene, scaled to the sensor's resolution."""

    def __init__(self, name: str, scene: Scene, sensor: int) -> None:
        super().__init__(name)
        self._scene, self._sensor = scene, sensor
        optics = scene.read_optics(sensor)
        self._size = (optics.width, optics.height)

    def _apply(self, image: Image) -> None:
        import cv2

        if (image.shape[1], image.shape[0]) != self._size:
            image = np.asarray(cv2.resize(image, self._size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
        self._scene.show(self._sensor, from_opencv(image))


def to_opencv(raw: RawPicture) -> Image:
    """Convert a simulator's picture to the layout of OpenCV: BGR, first row at the top.

    >>> to_opencv(RawPicture(bytes([1, 2, 3, 4, 5, 6]), width=1, height=2)).tolist()
    [[[6, 5, 4]], [[3, 2, 1]]]
    """
    import cv2

    rgb = np.frombuffer(raw.pixels, dtype=np.uint8).reshape(raw.height, raw.width, 3)
    return np.asarray(cv2.cvtColor(cv2.flip(rgb, 0), cv2.COLOR_RGB2BGR), dtype=np.uint8)


def from_opencv(image: Image) -> RawPicture:
    """Convert a picture in the layout of OpenCV to the layout of the simulators. The picture is BGR or grey."""
    colour = image if image.ndim == 3 else np.repeat(image[..., np.newaxis], 3, axis=2)
    return RawPicture(colour[::-1, :, ::-1].tobytes(), image.shape[1], image.shape[0])


def choose_intrinsics(description: CameraDescription, optics: CameraOptics, *, as_found: bool) -> Intrinsics:
    """Return the intrinsics of a camera in a scene, whose vision sensors have no lens.

    description: the camera of the robot's file.
    optics: the optics of the scene's vision sensor. If its field of view is None, that of ``description`` is used.
    as_found: whether to return the optics of the vision sensor if they differ from the description.

    Raises DeviceError if they differ and ``as_found`` is False. Fields of view may differ by `SAME_FOV_RAD`, because
    servers send them in single precision.
    """
    described = replace(description.intrinsics, centre=None, distortion=())
    actual = Intrinsics(optics.width, optics.height, optics.horizontal_fov or described.horizontal_fov)
    is_same_size = (actual.width, actual.height) == (described.width, described.height)
    if is_same_size and abs(actual.horizontal_fov - described.horizontal_fov) <= SAME_FOV_RAD:
        return described
    if as_found:
        return actual
    raise DeviceError(
        description.name,
        f"the vision sensor has {_format_optics(actual)}, the description has {_format_optics(described)}. "
        "Correct the scene or the robot's file, or write as_found = true below the camera's path to use the scene's "
        "vision sensor as it is",
        kind="different-optics",
        actual=_format_optics(actual),
        described=_format_optics(described),
    )


def _format_optics(intrinsics: Intrinsics) -> str:
    return f"{intrinsics.width}x{intrinsics.height} pixels over {math.degrees(intrinsics.horizontal_fov):.1f} degrees"


class SceneTruth:
    """The true pose and velocity of a robot, computed from the positions of its two wheels.

    The position is the centre of the axle. The heading is at right angles to the axle.
    """

    def __init__(self, scene: Scene, left: int, right: int) -> None:
        self._scene, self._left, self._right = scene, left, right
        self.pose()  # a scene reports velocities only after positions

    def pose(self) -> Pose:
        left, right = self._wheels()
        return Pose((left[0] + right[0]) / 2, (left[1] + right[1]) / 2, _compute_heading(left, right))

    def twist(self) -> Twist:
        left, right = self._wheels()
        heading = _compute_heading(left, right)
        on_left = _project(self._scene.read_velocity(self._left), heading)
        on_right = _project(self._scene.read_velocity(self._right), heading)
        return Twist((on_left + on_right) / 2, (on_right - on_left) / math.dist(left[:2], right[:2]))

    def contacts(self) -> None:
        """Return None, because the remote APIs do not report all contacts."""

    def _wheels(self) -> tuple[Point, Point]:
        return self._scene.read_position(self._left), self._scene.read_position(self._right)


def _compute_heading(left: Point, right: Point) -> float:
    return math.atan2(right[0] - left[0], left[1] - right[1])


def _project(velocity: Point, heading: float) -> float:
    return velocity[0] * math.cos(heading) + velocity[1] * math.sin(heading)
