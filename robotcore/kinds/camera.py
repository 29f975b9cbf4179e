"""A camera."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from robotcore.description import Ideal, Mount, SensorDescription
from robotcore.errors import Mistake
from robotcore.hal.clock import Clock
from robotcore.hal.device import Sensor
from robotcore.hal.kind import Kind, raise_not_simulated
from robotcore.hal.noise import Noise, build_noise_effect
from robotcore.hal.sampling import delay_samples
from robotcore.kinds.device_tests.cameras import test_cameras
from robotcore.lens import Lens, is_invertible
from robotcore.optics import Image, Intrinsics

__all__ = ["KIND", "Camera", "CameraDescription", "Frame"]

Coefficient = Annotated[float, Field(ge=-10, le=10)]
Pixel = Annotated[float, Field(ge=0, le=4096)]


class CameraDescription(SensorDescription):
    """A camera, which simulators model as a pinhole camera with a lens.

    >>> from robotcore.description import Mount
    >>> eye = CameraDescription(
    ...     kind="camera", name="eye", mount=Mount(z_m=0.1), width_px=320, height_px=240, horizontal_fov_rad=1.08
    ... )
    >>> eye.intrinsics
    Intrinsics(width=320, height=240, horizontal_fov=1.08, centre=None, distortion=())
    """

    kind: Literal["camera"]
    mount: Mount
    width_px: Annotated[int, Field(ge=16, le=4096)]
    """The width of a picture, in pixels."""
    height_px: Annotated[int, Field(ge=16, le=4096)]
    """The height of a picture, in pixels."""
    horizontal_fov_rad: Annotated[float, Field(ge=0.01, le=3)]
    """The full horizontal field of view of a lens without distortion, in radians.

    It determines the focal length. Pixels are square, so the vertical field of view follows.
    """
    centre_px: Annotated[
        Annotated[tuple[Pixel, Pixel], Field(description="[column, row] of the optical axis, in pixels")] | None,
        Ideal(None),
    ] = None
    """The column and the row of the optical axis, in pixels. With None, the axis is in the middle of the picture."""
    distortion: Annotated[
        tuple[Coefficient, Coefficient, Coefficient, Coefficient, Coefficient] | None,
        Field(description="the list [k1, k2, p1, p2, k3] of OpenCV"),
        Ideal(None),
    ] = None
    """The coefficients k1, k2, p1, p2 and k3 of the lens, as in OpenCV. With None, the lens does not distort."""
    noise_levels: Annotated[float, Field(ge=0, le=64), Ideal(0.0)] = 0.0
    """The standard deviation of the noise of a pixel, in grey levels from 0 to 255."""

    @model_validator(mode="after")
    def _require_lens(self) -> CameraDescription:
        if self.centre_px and not (self.centre_px[0] < self.width_px and self.centre_px[1] < self.height_px):
            problem = f"centre_px, {list(self.centre_px)}, is outside of a picture of {self.width_px}x{self.height_px}"
            raise Mistake(problem, "Give its column and its row", kind="centre-outside")
        if not self.intrinsics.is_pinhole and not is_invertible(self.intrinsics):
            problem = "with this distortion, the lens shows a direction twice or looks more than 80° aside"
            raise Mistake(problem, "Measure it: robotcore calibrate camera", kind="distortion-not-invertible")
        return self

    @property
    def intrinsics(self) -> Intrinsics:
        """The pinhole model, and the distortion of the lens."""
        size = self.width_px, self.height_px
        return Intrinsics(*size, self.horizontal_fov_rad, self.centre_px, self.distortion or ())

    def arguments(self) -> dict[str, Any]:
        return {"intrinsics": self.intrinsics}


@dataclass(frozen=True, eq=False, repr=False)
class Frame:
    """A sample of a camera.

    >>> import numpy as np
    >>> frame = Frame(np.zeros((120, 160, 3), np.uint8), time=1.25, sequence=25)
    >>> frame
    <Frame 160x120 at 1.25 s>
    >>> frame.grey.shape
    (120, 160)
    """

    image: Image
    """The BGR picture, shape (height, width, 3), read-only. The origin is the top left corner."""
    time: float
    """The time of capture on the robot's clock, in seconds."""
    sequence: int
    """The number of the frame. It grows with each new frame of a camera."""

    def __repr__(self) -> str:
        return f"<Frame {self.format_values()} at {self.time:.2f} s>"

    def _repr_png_(self) -> bytes:
        from robotcore.canvas import encode_png

        return encode_png(self.image)

    def format_values(self) -> str:
        height, width = self.image.shape[:2]
        return f"{width}x{height}"

    @cached_property
    def grey(self) -> Image:
        """The picture in grey, shape (height, width), read-only."""
        import cv2

        grey = np.asarray(cv2.cvtColor(self.image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
        grey.flags.writeable = False
        return grey


class Camera(Sensor[Frame]):
    """A camera. Its frames have BGR pictures, whose origin is the top left corner.

    An app reads the first camera as ``robot.camera``. ``mount`` is the camera's pose on the robot in the plane.

    name: the name of the camera, as in the robot's file.
    intrinsics: the pinhole model, with which a pixel becomes a direction.

    >>> import numpy as np
    >>> from robotcore.testing import MockRobot
    >>> camera = MockRobot(camera=np.zeros((240, 320, 3), np.uint8)).layered.camera
    >>> frame = camera.read()
    >>> frame
    <Frame 320x240 at 0.00 s>
    >>> frame.image[0, 0].tolist()  # the blue, green and red of a pixel: row, column
    [0, 0, 0]
    >>> camera.intrinsics.bearing(319.5)  # the right edge, in radians to the left
    -0.54105
    """

    kind = "camera"

    def __init__(self, name: str, intrinsics: Intrinsics) -> None:
        super().__init__(name)
        self.intrinsics = intrinsics

    def format_sample(self, sample: Frame) -> str:
        return f"{sample.format_values()} pixels"


Render = Callable[[], Image]
"""Renders a picture, (height, width, 3), BGR."""


class SimulatedCamera(Camera):
    """A simulated camera, with the latency, the lens and the noise of its description.

    capture: stores the camera's present view, and returns a function that renders its picture later. Its argument is
        the intrinsics of the picture, those of ``lens.pinhole``. A picture is rendered only if an app reads it.
    seed: the seed of the noise.
    intrinsics: the intrinsics of the camera; None for those of the description.
    """

    def __init__(
        self,
        description: CameraDescription,
        clock: Clock,
        capture: Callable[[Intrinsics], Render],
        seed: int,
        intrinsics: Intrinsics | None = None,
    ) -> None:
        super().__init__(description.name, intrinsics or description.intrinsics)
        self.lens = Lens(self.intrinsics)
        """The lens, which bends the pictures of its pinhole camera."""
        self._noise = Noise(seed, f"{self.name}:pixels", description.noise_levels) if description.noise_levels else None

        def begin(time: float, sequence: int) -> Callable[[], Frame]:
            render = capture(self.lens.pinhole)
            return lambda: Frame(self._develop(render(), time), time, sequence)

        self._newest_at = delay_samples(clock, description, begin)

    def _develop(self, image: Image, time: float) -> Image:
        image = self.lens.bend(image)
        if self._noise:
            image = build_noise_effect(self._noise)(image, time)
        image.flags.writeable = False
        return image

    def _newest(self) -> Frame:
        return self._newest_at()

    def _release(self) -> None:
        self._newest_at.close()


def draw_grey(camera: CameraDescription) -> Image:
    """Return a grey picture of a camera's size, the reading of a mock camera without a script."""
    return np.full((camera.height_px, camera.width_px, 3), 128, dtype=np.uint8)


def validate_sample(camera: CameraDescription, frame: Frame) -> Frame:
    """Return a scripted frame with a read-only copy of its picture. Raises ValueError for a picture of another form."""
    image: object = frame.image
    shape = (camera.height_px, camera.width_px, 3)
    if not isinstance(image, np.ndarray) or image.shape != shape or image.dtype != np.uint8:
        raise ValueError(f"a uint8 picture of shape {shape}")
    image = image.copy(order="C")
    image.flags.writeable = False
    return replace(frame, image=image)


KIND = Kind(
    "a camera",
    CameraDescription,
    Camera,
    Frame,
    raise_not_simulated,
    default_reading=draw_grey,
    validate_sample=validate_sample,
    test_devices=test_cameras,
)
"""The kind `camera`, which the entry point of this name refers to."""
