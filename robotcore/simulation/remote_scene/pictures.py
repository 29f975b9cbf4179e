"""Vision sensors of a scene: one as a camera, one as the display that its picture goes back to."""

from __future__ import annotations

import math

import numpy as np

from robotcore.description import CameraDescription
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Camera, Display, Frame, Image
from robotcore.optics import Intrinsics
from robotcore.simulation.remote_scene.port import Lens, RawPicture, Scene
from robotcore.simulation.sampling import OnceAnInstant

SAME_FOV_RAD = math.radians(0.5)
"""By so much a field of view may differ from the one described: half a pixel or two, at the edge of a picture."""


class SceneCamera(Camera):
    """What a vision sensor sees; its pixels are fetched when they are read."""

    def __init__(self, name: str, intrinsics: Intrinsics, scene: Scene, sensor: int, clock: Clock) -> None:
        super().__init__(name, intrinsics)
        self._scene, self._sensor = scene, sensor
        self._newest_at = OnceAnInstant(clock, self._expose)

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
        return Frame(upright(raw), time, sequence)


class SceneDisplay(Display):
    """Shows a picture of any size on a vision sensor, as large as that is; upright for the one who looks."""

    def __init__(self, name: str, scene: Scene, sensor: int) -> None:
        super().__init__(name)
        self._scene, self._sensor = scene, sensor
        lens = scene.lens(sensor)
        self._size = (lens.width, lens.height)

    def _show(self, image: Image) -> None:
        import cv2

        if (image.shape[1], image.shape[0]) != self._size:
            image = np.asarray(cv2.resize(image, self._size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
        self._scene.show(self._sensor, upended(image))


def upright(raw: RawPicture) -> Image:
    """Return a picture as apps get it: BGR, top-left origin, read-only.

    >>> upright(RawPicture(bytes([1, 2, 3, 4, 5, 6]), width=1, height=2)).tolist()
    [[[6, 5, 4]], [[3, 2, 1]]]
    """
    import cv2

    rgb = np.frombuffer(raw.pixels, dtype=np.uint8).reshape(raw.height, raw.width, 3)
    image = np.asarray(cv2.cvtColor(cv2.flip(rgb, 0), cv2.COLOR_RGB2BGR), dtype=np.uint8)
    image.flags.writeable = False
    return image


def upended(image: Image) -> RawPicture:
    """Return a picture, BGR or grey with a top-left origin, as simulators keep it."""
    colour = image if image.ndim == 3 else np.repeat(image[..., np.newaxis], 3, axis=2)
    return RawPicture(colour[::-1, :, ::-1].tobytes(), image.shape[1], image.shape[0])


def intrinsics_of(description: CameraDescription, lens: Lens, *, as_found: bool) -> Intrinsics:
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
        f"its vision sensor sees {_told(seen)}, the description says {_told(described)}. Make them alike, in the "
        "scene or in the robot's file, or let the scene's count: as_found = true beside its path",
    )


def _told(seen: Intrinsics) -> str:
    return f"{seen.width}x{seen.height} pixels over {math.degrees(seen.horizontal_fov):.1f} degrees"
