"""A camera on the Pi's ribbon connector, by picamera2.

Source of the calls: https://github.com/raspberrypi/picamera2, picamera2/picamera2.py and request.py.
Source of the controls: https://libcamera.org/api-html/namespacelibcamera_1_1controls.html.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import TimeoutError as TimedOutError
from contextlib import suppress
from typing import Annotated, Any

from pydantic import Field

from drivers.raspberrypi.cameras.capture import (
    CameraDriver,
    Shot,
    Source,
    TimestampConverter,
)
from robotcore.errors import DeviceError
from robotcore.hardware import Connection

BGR = "RGB888"
"""picamera2's name of the format blue, green, red. The names list the bytes in reverse order.

Source: https://github.com/raspberrypi/picamera2/issues/848."""

PICTURE_TIMEOUT_S = 2.0
"""A camera that delivers no picture for this many seconds has failed. The longest exposure in a robot's file is 1 s."""

SETTINGS = {
    "FrameDurationLimits": "fps",
    "ExposureTime": "exposure_s",
    "AnalogueGain": "gain",
    "ColourGains": "colour_gains",
}
"""libcamera's controls, and the keys of their settings in a robot's file."""

LOCKING_CONTROLS = {"ExposureTime": "exposure", "AnalogueGain": "gain", "ColourGains": "white balance"}
"""libcamera's controls that lock exposure and white balance, and their names in messages. The metadata of a picture has
the same keys."""


Gain = Annotated[float, Field(gt=0, le=32)]
Gains = Annotated[tuple[Gain, Gain], Field(description="[red, blue]")]


class CsiSource(Source["PiCamera"]):
    """Takes pictures from a camera on the Pi's connector by picamera2.

    The time of a picture is the sensor's timestamp of reading the first row, right after the exposure of that row. It
    is accurate to a millisecond.
    """

    _camera: Any = None

    def open(self) -> list[str]:
        library, number = import_picamera2(self.name), self.settings.camera
        self._require_camera(library.Picamera2.global_camera_info())
        self._stamps = TimestampConverter(self.clock)
        requested = _build_controls(self.settings)
        try:
            self._camera = library.Picamera2(number)
            known = self._select_known(requested)
            mode = choose_mode(self._camera.sensor_modes, self.settings.fps)
            configuration = self._camera.create_video_configuration(
                main={"format": BGR, "size": (self.description.width_px, self.description.height_px)},
                raw=None,
                sensor={"output_size": mode["size"], "bit_depth": mode["bit_depth"]} if mode else {},
                controls=known,
            )
            self._camera.configure(configuration)
            self._camera.start()
        except (RuntimeError, OSError) as error:
            message = f"camera {number} cannot be opened ({error}). End any other program that uses it"
            raise DeviceError(self.name, message, kind="camera-not-opened") from error
        return [SETTINGS[control] for control in requested if control not in known]

    def shoot(self) -> Shot:
        try:
            request = self._camera.capture_request(wait=PICTURE_TIMEOUT_S)
        except TimedOutError as error:
            self._camera.cancel_all_and_flush()  # otherwise the camera cannot be closed
            message = (
                f"no picture for {PICTURE_TIMEOUT_S:g} s. Switch the power off, and push its ribbon cable fully in"
            )
            raise DeviceError(self.name, message, kind="camera-silent") from error
        try:
            metadata = request.get_metadata()
            return Shot(request.make_array("main"), self._stamps.time_of(metadata["SensorTimestamp"] / 1e9), metadata)
        finally:
            request.release()

    def read_exposure(self, shot: Shot) -> Sequence[float]:
        metadata = shot.metadata
        return (metadata["ExposureTime"] * metadata["AnalogueGain"], *metadata.get("ColourGains", ()))

    def lock_exposure(self, shot: Shot) -> list[str]:
        found = {control: shot.metadata[control] for control in LOCKING_CONTROLS if control in shot.metadata}
        known = self._select_known({"AeEnable": False, "AwbEnable": False, **found})
        self._camera.set_controls(known)
        return [LOCKING_CONTROLS[control] for control in found if control not in known]

    def close(self) -> None:
        camera, self._camera = self._camera, None
        if camera is not None:
            with suppress(RuntimeError, OSError):
                camera.close()

    def _select_known(self, controls: Mapping[str, Any]) -> dict[str, Any]:
        # picamera2 raises an error for a control that the camera does not have.
        return {name: value for name, value in controls.items() if name in self._camera.camera_controls}

    def _require_camera(self, found: Sequence[Mapping[str, Any]]) -> None:
        number = self.settings.camera
        if number < len(found):
            return
        cameras = ", ".join(f"{index} ({camera['Model']})" for index, camera in enumerate(found))
        offer = f"It has: {cameras}" if cameras else "It has none. Switch the power off, and check the ribbon cable"
        raise DeviceError(
            self.name,
            f"the Pi has no camera {number}. {offer}. List cameras: rpicam-hello --list-cameras",
            kind="camera-missing",
        )


def _build_controls(settings: PiCamera) -> dict[str, Any]:
    frame_us = round(1e6 / settings.fps)
    exposure_us = None if settings.exposure_s is None else round(settings.exposure_s * 1e6)
    controls = {
        "FrameDurationLimits": (frame_us, max(frame_us, exposure_us or 0)),
        "ExposureTime": exposure_us,
        "AnalogueGain": settings.gain,
        "ColourGains": settings.colour_gains,
    }
    return {name: value for name, value in controls.items() if value is not None}


REMEDY = "On the Pi: sudo apt install python3-picamera2, and a venv made with --system-site-packages"

OTHER_NUMPY = "In the venv: pip install 'numpy<2' 'opencv-python-headless<4.12'"
"""The remedy if picamera2 was built for another version of NumPy. Raspberry Pi OS 12 builds it for NumPy 1.24. OpenCV
4.12 needs NumPy 2."""


def import_picamera2(camera: str) -> Any:
    """Return the module picamera2; raises DeviceError if it is missing or was built for another NumPy.

    camera: the camera's name, for the error.
    """
    try:
        import picamera2
    except ImportError as error:
        raise DeviceError(
            camera, f"picamera2 is not installed ({error}). {REMEDY}", kind="picamera2-missing"
        ) from error
    except ValueError as error:  # Source: https://github.com/raspberrypi/picamera2/issues/1088
        raise DeviceError(
            camera,
            f"picamera2 is built for another NumPy than this one ({error}). {OTHER_NUMPY}",
            kind="picamera2-other-numpy",
        ) from error
    return picamera2


Mode = Mapping[str, Any]
"""A mode of the sensor, from picamera2: ``size``, ``bit_depth``, highest ``fps`` and ``crop_limits`` (x, y, w, h)."""


def choose_mode(modes: Sequence[Mode], fps: float) -> Mode | None:
    """Return the smallest mode that reads the whole sensor at ``fps`` pictures a second.

    If no mode is fast enough, return the fastest mode that reads the whole sensor. Return None if the modes do
    not state which part of the sensor they read.

    By default libcamera uses the mode nearest to the picture's size. For a small picture this mode may read only the
    middle of the sensor, which halves the field of view.
    """
    usable = [mode for mode in modes if "crop_limits" in mode]
    widest = max((math.prod(mode["crop_limits"][2:]) for mode in usable), default=0)
    wide = [mode for mode in usable if math.prod(mode["crop_limits"][2:]) == widest]
    if quick := [mode for mode in wide if mode["fps"] >= fps]:
        return min(quick, key=lambda mode: (math.prod(mode["size"]), -mode["bit_depth"]))
    return max(wide, key=lambda mode: mode["fps"], default=None)


class PiCamera(CameraDriver):
    """Opens cameras on the Pi's connector by picamera2. Raspberry Pi OS has version 0.3.20 or newer."""

    name = "picamera2"
    summary = "a camera on the Pi's ribbon connector"
    source = CsiSource
    aliases = ("pi-camera", "csi", "libcamera", "camera-module")
    modules = ("picamera2",)
    connector = "CSI"
    remedy = REMEDY

    camera: Annotated[int, Field(ge=0, le=7)] = 0
    """The number of the camera in the list of ``rpicam-hello --list-cameras``."""

    gain: Annotated[float, Field(ge=1, le=64)] | None = None
    """A fixed gain of the sensor; None means automatic."""

    colour_gains: Gains | None = None
    """The gains of red and blue, for a fixed white balance. None means automatic."""

    def connections(self) -> Sequence[Connection]:
        return (Connection("camera", "CSI", str(self.camera)),)
