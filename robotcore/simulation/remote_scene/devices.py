"""Motors, encoders, range sensors, cameras, displays and the ground truth of a remote scene."""

from __future__ import annotations

import math
from threading import Lock

import numpy as np

from robotcore.description import CameraDescription, EncoderDescription, MotorDescription, RangeSensorDescription
from robotcore.errors import DeviceError
from robotcore.geometry import Pose, Twist
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Angle, Camera, Display, Encoder, Frame, Image, Motor, Range, RangeSensor
from robotcore.optics import Intrinsics
from robotcore.simulation.remote_scene.interface import CameraOptics, Point, RawPicture, Scene
from robotcore.simulation.sampling import SampleCache


class SceneMotor(Motor):
    """Gives a joint its target velocity; ``is_reversed`` where the joint turns the other way round."""

    def __init__(self, description: MotorDescription, scene: Scene, joint: int, *, is_reversed: bool) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._scene, self._joint = scene, joint
        self._sign = -1.0 if is_reversed else 1.0

    def _apply(self, rad_s: float) -> None:
        self._scene.set_joint_velocity(self._joint, float(self._sign * rad_s))  # never a type of NumPy's


class SceneEncoder(Encoder):
    """Whole counts of a joint's angle since the robot was opened.

    The server tells no turns: a joint that passes π is at -π. So the angle is looked at every ``period`` seconds, in
    which no wheel may turn by half a turn.
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
        self._position = scene.joint_position
        self._joint, self._sign = joint, -1.0 if is_reversed else 1.0
        self._quantised = description.quantised
        self._turned, self._seen = 0.0, self._position(joint)
        self._lock = Lock()
        self._newest_at = SampleCache(clock, self._count)
        self._looking = clock.every(period, self._newest, self.name)

    def _newest(self) -> Angle:
        with self._lock:
            return self._newest_at()

    def _count(self, time: float, sequence: int) -> Angle:
        seen = self._position(self._joint)
        self._turned += math.remainder(seen - self._seen, math.tau)
        self._seen = seen
        return Angle(self._quantised(self._sign * self._turned), time, sequence)

    def _release(self) -> None:
        self._looking.stop()


class SceneRangeSensor(RangeSensor):
    """The way to the point that a proximity sensor detects.

    The point itself is not told: how somebody's sensor is turned about its axis is not known.
    """

    def __init__(self, description: RangeSensorDescription, scene: Scene, sensor: int, clock: Clock) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)
        self._scene, self._sensor = scene, sensor
        self._newest_at = SampleCache(clock, self._sense)

    def _newest(self) -> Range:
        return self._newest_at()

    def _sense(self, time: float, sequence: int) -> Range:
        point = self._scene.detect(self._sensor)
        distance = math.inf if point is None else math.hypot(*point)
        return Range(math.inf if distance > self.max_range else max(distance, self.min_range), time, sequence)


SAME_FOV_RAD = math.radians(0.5)
"""By so much a field of view may differ from the one described: half a pixel or two, at the edge of a picture."""


class SceneCamera(Camera):
    """What a vision sensor sees; its pixels are fetched when they are read."""

    def __init__(self, name: str, intrinsics: Intrinsics, scene: Scene, sensor: int, clock: Clock) -> None:
        super().__init__(name, intrinsics)
        self._scene, self._sensor = scene, sensor
        self._newest_at = SampleCache(clock, self._expose)

    def _newest(self) -> Frame:
        return self._newest_at()

    def _expose(self, time: float, sequence: int) -> Frame:
        raw = self._scene.picture(self._sensor)
        if (raw.width, raw.height) != (self.intrinsics.width, self.intrinsics.height):
            raise DeviceError(
                self.name,
                f"a picture of {raw.width}x{raw.height} came, expected {self.intrinsics.width}x"
                f"{self.intrinsics.height}; leave the vision sensor's resolution alone while the robot is open",
            )
        return Frame(to_opencv(raw), time, sequence)


class SceneDisplay(Display):
    """Shows a picture of any size on a vision sensor, as large as that is; upright for the one who looks."""

    def __init__(self, name: str, scene: Scene, sensor: int) -> None:
        super().__init__(name)
        self._scene, self._sensor = scene, sensor
        lens = scene.optics(sensor)
        self._size = (lens.width, lens.height)

    def _show(self, image: Image) -> None:
        import cv2

        if (image.shape[1], image.shape[0]) != self._size:
            image = np.asarray(cv2.resize(image, self._size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
        self._scene.show(self._sensor, from_opencv(image))


def to_opencv(raw: RawPicture) -> Image:
    """Return a picture as apps get it: BGR, top-left origin, read-only.

    >>> to_opencv(RawPicture(bytes([1, 2, 3, 4, 5, 6]), width=1, height=2)).tolist()
    [[[6, 5, 4]], [[3, 2, 1]]]
    """
    import cv2

    rgb = np.frombuffer(raw.pixels, dtype=np.uint8).reshape(raw.height, raw.width, 3)
    image = np.asarray(cv2.cvtColor(cv2.flip(rgb, 0), cv2.COLOR_RGB2BGR), dtype=np.uint8)
    image.flags.writeable = False
    return image


def from_opencv(image: Image) -> RawPicture:
    """Return a picture, BGR or grey with a top-left origin, as simulators keep it."""
    colour = image if image.ndim == 3 else np.repeat(image[..., np.newaxis], 3, axis=2)
    return RawPicture(colour[::-1, :, ::-1].tobytes(), image.shape[1], image.shape[0])


def intrinsics_of(description: CameraDescription, lens: CameraOptics, *, as_found: bool) -> Intrinsics:
    """Return a camera's intrinsics: those described, or those of its vision sensor ``as_found`` where they differ.

    Raises DeviceError where they are to be alike and are not. Where the server tells no field of view, the one
    described is believed; servers tell it in single precision.
    """
    described = description.intrinsics
    seen = Intrinsics(lens.width, lens.height, lens.horizontal_fov or described.horizontal_fov)
    is_alike = (seen.width, seen.height) == (described.width, described.height)
    if is_alike and abs(seen.horizontal_fov - described.horizontal_fov) <= SAME_FOV_RAD:
        return described
    if as_found:
        return seen
    raise DeviceError(
        description.name,
        f"its vision sensor sees {_format_optics(seen)}, the description says {_format_optics(described)}. "
        "Make them alike, in the scene or in the robot's file, or let the scene's count: as_found = true "
        "beside its path",
    )


def _format_optics(seen: Intrinsics) -> str:
    return f"{seen.width}x{seen.height} pixels over {math.degrees(seen.horizontal_fov):.1f} degrees"


class SceneTruth:
    """The robot is where the middle of its axle is, and looks square to it. Touches are not told."""

    def __init__(self, scene: Scene, left: int, right: int) -> None:
        self._scene, self._left, self._right = scene, left, right
        self.pose()  # from now on velocities are known too

    def pose(self) -> Pose:
        left, right = self._wheels()
        return Pose((left[0] + right[0]) / 2, (left[1] + right[1]) / 2, _heading(left, right))

    def twist(self) -> Twist:
        left, right = self._wheels()
        heading = _heading(left, right)
        on_left = _along(self._scene.velocity(self._left), heading)
        on_right = _along(self._scene.velocity(self._right), heading)
        return Twist((on_left + on_right) / 2, (on_right - on_left) / math.dist(left[:2], right[:2]))

    def contacts(self) -> None:
        """Return None: a server that is asked from afar tells too few of them."""

    def _wheels(self) -> tuple[Point, Point]:
        return self._scene.position(self._left), self._scene.position(self._right)


def _heading(left: Point, right: Point) -> float:
    """Return where a robot looks between whose wheels the axle is."""
    return math.atan2(right[0] - left[0], left[1] - right[1])


def _along(velocity: Point, heading: float) -> float:
    return velocity[0] * math.cos(heading) + velocity[1] * math.sin(heading)
