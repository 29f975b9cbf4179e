"""A double of picamera2, as strict as the real one.

Names, formats, defaults and refusals follow https://github.com/raspberrypi/picamera2 (0.3.20 to 0.3.36):
picamera2/picamera2.py, request.py (`make_array`), controls.py, formats.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import TimeoutError as TimedOutError
from types import ModuleType
from typing import Any, ClassVar

import numpy as np

from robotcore.optics import Image
from tests.drivers.raspberrypi.cameras.fakes import RED_RGB, LabClock

CHANNELS = {"BGR888": (0, 1, 2), "RGB888": (2, 1, 0)}
"""The order of red, green and blue in an array: the reverse of the format's name."""

FOUND_US, FOUND_GAIN, FOUND_GAINS = 12_000, 2.0, (1.8, 1.4)
CONTROLS = ("AeEnable", "AwbEnable", "ExposureTime", "AnalogueGain", "ColourGains", "FrameDurationLimits")
IMX219 = [
    {"size": (640, 480), "bit_depth": 10, "fps": 206.65, "crop_limits": (1000, 752, 1280, 960)},
    {"size": (1640, 1232), "bit_depth": 8, "fps": 83.7, "crop_limits": (0, 0, 3280, 2464)},
    {"size": (1640, 1232), "bit_depth": 10, "fps": 41.85, "crop_limits": (0, 0, 3280, 2464)},
    {"size": (1920, 1080), "bit_depth": 10, "fps": 47.57, "crop_limits": (680, 692, 1920, 1080)},
    {"size": (3280, 2464), "bit_depth": 10, "fps": 21.19, "crop_limits": (0, 0, 3280, 2464)},
]


class FakeRequest:
    """A buffer of the camera, which must be released once."""

    def __init__(self, camera: FakePicamera2, metadata: dict[str, Any]) -> None:
        self._camera, self._metadata = camera, metadata

    def get_metadata(self) -> dict[str, Any]:
        return dict(self._metadata)

    def make_array(self, name: str) -> Image:
        stream = self._camera.config[name]
        width, height = stream["size"]
        colour = np.array([RED_RGB[channel] for channel in CHANNELS[stream["format"]]])
        seen = self._metadata["ExposureTime"] * self._metadata["AnalogueGain"] / (FOUND_US * FOUND_GAIN)
        return np.full((height, width, 3), np.clip(colour * seen * self._camera.hardware.lamp, 0, 255), np.uint8)

    def release(self) -> None:
        self._camera.outstanding -= 1
        assert self._camera.outstanding >= 0, "lock now has negative ref_count"


class FakePicamera2:
    """An open camera, which settles its exposure in twenty pictures."""

    hardware: ClassVar[FakeCamera]

    def __init__(self, camera_num: int = 0) -> None:
        if self.hardware.is_busy:
            raise RuntimeError("Camera __init__ sequence did not complete.")
        self.hardware.last = self
        self.camera_controls = dict.fromkeys(self.hardware.controls, (0, 1, None))
        self.config: dict[str, Any] = {}
        self.set: dict[str, Any] = {}
        self.outstanding = self.flushes = 0
        self.is_started = self.is_closed = False
        self._exposures = [FOUND_US * step // 20 for step in range(1, 20)]

    @staticmethod
    def global_camera_info() -> list[dict[str, Any]]:
        return [{"Model": model, "Num": number} for number, model in enumerate(FakePicamera2.hardware.models)]

    @property
    def sensor_modes(self) -> list[dict[str, Any]]:
        assert not self.is_started, "Camera must be stopped before configuring"
        return self.hardware.modes

    def create_video_configuration(
        self, *, main: Mapping[str, Any], raw: None, sensor: Mapping[str, Any], controls: Mapping[str, Any]
    ) -> dict[str, Any]:
        assert set(main) <= {"format", "size", "stride", "preserve_ar"}
        width, height = main["size"]
        stream = {**main, "size": (width - width % 2, height - height % 2)}
        return {"main": stream, "raw": raw, "sensor": sensor, "buffer_count": 6, "controls": dict(controls)}

    def configure(self, config: dict[str, Any]) -> None:
        assert not self.is_started, "Camera must be stopped before configuring"
        assert set(config["sensor"]) <= {"bit_depth", "output_size"}
        assert config["main"]["format"] in CHANNELS
        self.config = config
        self.set_controls(config["controls"])

    def set_controls(self, controls: Mapping[str, Any]) -> None:
        if unknown := set(controls) - set(self.hardware.controls):
            raise RuntimeError(f"Control {unknown} is not advertised by libcamera")
        self.set |= controls

    def start(self) -> None:
        assert self.config, "Camera has not been configured"
        self.is_started = True

    def capture_request(self, wait: float | None = None) -> FakeRequest:
        assert self.is_started
        if self.hardware.is_hanging or self.outstanding == self.config["buffer_count"]:
            assert wait, "without a timeout this wait would never end"
            raise TimedOutError
        self.outstanding += 1
        return FakeRequest(self, self._metadata())

    def cancel_all_and_flush(self) -> None:
        self.flushes += 1

    def close(self) -> None:
        self.is_closed = True

    def _metadata(self) -> dict[str, Any]:
        hardware = self.hardware
        exposure = self._exposures.pop(0) if self._exposures else FOUND_US
        if self.set.get("AeEnable", True):
            exposure = round(exposure / hardware.lamp)
        return {
            "SensorTimestamp": round((hardware.clock.monotonic_s - hardware.latency_s) * 1e9),
            "ExposureTime": self.set.get("ExposureTime", exposure),
            "AnalogueGain": self.set.get("AnalogueGain", FOUND_GAIN),
            "ColourGains": self.set.get("ColourGains", FOUND_GAINS),
        }


class FakeCamera:
    """The simulated hardware, and in ``last`` the camera that was opened last."""

    last: FakePicamera2

    def __init__(self, clock: LabClock) -> None:
        self.clock = clock
        self.models = ["imx219"]
        self.modes: list[dict[str, Any]] = list(IMX219)
        self.controls: tuple[str, ...] = CONTROLS
        self.lamp, self.latency_s = 1.0, 0.012
        self.is_busy = self.is_hanging = False

    def module(self) -> ModuleType:
        """Return the module for ``import picamera2``."""
        module = ModuleType("picamera2")
        FakePicamera2.hardware = self
        module.Picamera2 = FakePicamera2  # type: ignore[attr-defined]
        return module
