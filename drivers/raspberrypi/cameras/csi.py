"""A camera on the Pi's ribbon connector, by picamera2.

What is asked of picamera2: https://github.com/raspberrypi/picamera2, picamera2/picamera2.py and request.py; what the
controls mean: https://libcamera.org/api-html/namespacelibcamera_1_1controls.html.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import TimeoutError as TimedOutError
from contextlib import suppress
from typing import Any

from drivers.raspberrypi.cameras.csicameras import imported, require_there
from drivers.raspberrypi.cameras.modes import widest
from drivers.raspberrypi.cameras.settings import PiCameraSettings
from drivers.raspberrypi.cameras.source import Light, Shot, Source
from drivers.raspberrypi.cameras.stamps import Stamps
from robotcore.description import CameraDescription
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock

BGR = "RGB888"
"""picamera2 names a format by its bytes from the last to the first: in an array, this one is blue, green, red.
Source: https://github.com/raspberrypi/picamera2/issues/848."""

PATIENCE_S = 2.0
"""A camera that gives no picture for as long hangs; the longest exposure that can be set is half of it."""

SEARCHING = 1
"""AeState of libcamera 0.5 and newer; before, there was AeLocked."""

SETTINGS = {
    "FrameDurationLimits": "fps",
    "ExposureTime": "exposure_s",
    "AnalogueGain": "gain",
    "ColourGains": "colour_gains",
}
"""libcamera's controls, and what sets them in a robot's file."""

HELD = {"ExposureTime": "exposure", "AnalogueGain": "gain", "ColourGains": "white balance"}
"""What exposure and white balance come to: controls, which a picture's metadata tells too."""


class CsiSource(Source):
    """A picture's time is the sensor's: when its first row was read out, after its exposure, to a millisecond."""

    def __init__(self, told: CameraDescription, settings: PiCameraSettings, clock: Clock) -> None:
        super().__init__(told.name)
        self._told, self._settings, self._clock = told, settings, clock
        self._camera: Any = None

    def open(self) -> list[str]:
        library, number = imported(self.name), self._settings.camera
        require_there(self.name, library, number)
        self._stamps = Stamps(self._clock)
        asked = _controls(self._settings)
        try:
            self._camera = library.Picamera2(number)
            known = self._known(asked)
            self._camera.configure(self._configuration(known))
            self._camera.start()
        except (RuntimeError, OSError) as error:
            words = f"camera {number} cannot be opened ({error}); is another program using it?"
            raise DeviceError(self.name, words) from error
        return [SETTINGS[control] for control in asked if control not in known]

    def shoot(self) -> Shot:
        try:
            request = self._camera.capture_request(wait=PATIENCE_S)
        except TimedOutError as error:
            self._camera.cancel_all_and_flush()  # else it could not be closed
            words = f"has given no picture for {PATIENCE_S:g} s; with the power off, push its ribbon cable home"
            raise DeviceError(self.name, words) from error
        try:
            told = request.get_metadata()
            return Shot(request.make_array("main"), self._stamps.time_of(told["SensorTimestamp"] / 1e9), told)
        finally:
            request.release()

    def light(self, shot: Shot) -> Light:
        told = shot.told
        is_found = told["AeState"] != SEARCHING if "AeState" in told else told.get("AeLocked")
        return Light((told["ExposureTime"] * told["AnalogueGain"], *told.get("ColourGains", ())), is_found)

    def hold(self, shot: Shot) -> list[str]:
        found = {control: shot.told[control] for control in HELD if control in shot.told}
        known = self._known({"AeEnable": False, "AwbEnable": False, **found})
        self._camera.set_controls(known)
        return [HELD[control] for control in found if control not in known]

    def close(self) -> None:
        camera, self._camera = self._camera, None
        if camera is not None:
            with suppress(RuntimeError, OSError):
                camera.close()

    def _known(self, controls: Mapping[str, Any]) -> dict[str, Any]:
        """Return those of the controls that the camera has; picamera2 refuses the others."""
        return {name: value for name, value in controls.items() if name in self._camera.camera_controls}

    def _configuration(self, controls: Mapping[str, Any]) -> Any:
        mode = widest(self._camera.sensor_modes, self._settings.fps)
        return self._camera.create_video_configuration(
            main={"format": BGR, "size": (self._told.width_px, self._told.height_px)},
            raw=None,
            sensor={"output_size": mode["size"], "bit_depth": mode["bit_depth"]} if mode else {},
            controls=controls,
        )


def _controls(settings: PiCameraSettings) -> dict[str, Any]:
    """Return what the settings ask for, in libcamera's units: microseconds."""
    frame_us = round(1e6 / settings.fps)
    exposure_us = None if settings.exposure_s is None else round(settings.exposure_s * 1e6)
    controls = {
        "FrameDurationLimits": (frame_us, max(frame_us, exposure_us or 0)),
        "ExposureTime": exposure_us,
        "AnalogueGain": settings.gain,
        "ColourGains": settings.colour_gains,
    }
    return {name: value for name, value in controls.items() if value is not None}
