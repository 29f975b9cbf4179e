"""A camera."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from robotcore.description import DeviceDescription, Mount
from robotcore.hal.clock import Clock
from robotcore.hal.device import Sensor
from robotcore.hal.kind import Kind, raise_not_simulated
from robotcore.hal.sampling import SampleCache
from robotcore.optics import Image, Intrinsics


class CameraDescription(DeviceDescription):
    """A camera, which simulators model as a pinhole camera."""

    kind: Literal["camera"]
    mount: Mount
    width_px: Annotated[int, Field(ge=16, le=4096)]
    """The width of a picture, in pixels."""
    height_px: Annotated[int, Field(ge=16, le=4096)]
    """The height of a picture, in pixels."""
    horizontal_fov_rad: Annotated[float, Field(ge=0.01, le=3)]
    """The full horizontal field of view, in radians. Pixels are square, so the vertical field of view follows."""

    @property
    def intrinsics(self) -> Intrinsics:
        return Intrinsics(self.width_px, self.height_px, self.horizontal_fov_rad)

    def arguments(self) -> dict[str, Any]:
        return {"intrinsics": self.intrinsics}


@dataclass(frozen=True, eq=False, repr=False)
class Frame:
    """A sample of a camera.

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
    """A camera. ``intrinsics`` is its pinhole model, and ``mount`` is its pose on the robot in the plane."""

    kind = "camera"

    def __init__(self, name: str, intrinsics: Intrinsics) -> None:
        super().__init__(name)
        self.intrinsics = intrinsics

    def format_sample(self, sample: Frame) -> str:
        return f"{sample.format_values()} pixels"


class SimulatedCamera(Camera):
    """A simulated camera.

    take_picture: returns a new picture, (height, width, 3), BGR. The camera makes it read-only.
    """

    def __init__(self, name: str, intrinsics: Intrinsics, clock: Clock, take_picture: Callable[[], Image]) -> None:
        super().__init__(name, intrinsics)

        def take(time: float, sequence: int) -> Frame:
            image = take_picture()
            image.flags.writeable = False
            return Frame(image, time, sequence)

        self._newest_at = SampleCache(clock, take)

    def _newest(self) -> Frame:
        return self._newest_at()


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
)
