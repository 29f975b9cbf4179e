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

from robotcore.hal.devices import Image
from tests.drivers.raspberrypi.cameras.fakes import RED_RGB, LabClock

STREAM_KEYS = {"format", "size", "stride", "preserve_ar"}
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
    """A buffer of the camera, which must be released."""

    def __init__(self, camera: FakePicamera2, metadata: dict[str, Any]) -> None:
        self._camera, self._metadata = camera, metadata
        self._is_released = False

    def get_metadata(self) -> dict[str, Any]:
        return dict(self._metadata)

    def make_array(self, name: str) -> Image:
        stream = self._camera.config[name]
        width, height = stream["size"]
        colour = [RED_RGB[channel] for channel in CHANNELS[stream["format"]]]
        seen = self._metadata["ExposureTime"] * self._metadata["AnalogueGain"] / (FOUND_US * FOUND_GAIN)
        lit = np.clip(np.array(colour) * seen * self._camera.lamp, 0, 255)
        return np.full((height, width, 3), lit, np.uint8)

    def release(self) -> None:
        assert not self._is_released, "lock now has negative ref_count"
        self._is_released = True
        self._camera.outstanding -= 1


class FakePicamera2:
    """Settles its exposure in twenty pictures. ``bench`` is the simulated hardware."""

    bench: ClassVar[FakeCamera]

    def __init__(self, camera_num: int = 0) -> None:
        self.bench.opened.append(self)
        if self.bench.is_busy:
            raise RuntimeError("Camera __init__ sequence did not complete.")
        self.config: dict[str, Any] = {}
        self.set: dict[str, Any] = {}
        self.outstanding = 0
        self.is_started = self.is_closed = False
        self.flushes = 0
        self._exposures = [FOUND_US * step // 20 for step in range(1, 20)]

    @staticmethod
    def global_camera_info() -> list[dict[str, Any]]:
        return [
            {"Model": model, "Location": 2, "Rotation": 180, "Id": f"/base/{model}", "Num": number}
            for number, model in enumerate(FakePicamera2.bench.models)
        ]

    @property
    def lamp(self) -> float:
        return self.bench.lamp

    @property
    def camera_controls(self) -> dict[str, tuple[Any, Any, Any]]:
        return dict.fromkeys(self.bench.controls, (0, 1, None))

    @property
    def sensor_modes(self) -> list[dict[str, Any]]:
        assert not self.is_started, "Camera must be stopped before configuring"
        return self.bench.modes

    def create_video_configuration(
        self,
        main: Mapping[str, Any] = {},
        lores: Mapping[str, Any] | None = None,
        raw: Mapping[str, Any] | None = {},
        controls: Mapping[str, Any] = {},
        sensor: Mapping[str, Any] | None = {},
        *,
        queue: bool = True,
        buffer_count: int = 6,
    ) -> dict[str, Any]:
        if not set(main) <= STREAM_KEYS:
            raise ValueError(f"valid stream configuration keys are {STREAM_KEYS}")
        stream = {"format": "XBGR8888", "size": (1280, 720), "preserve_ar": True, **main}
        width, height = stream["size"]
        stream["size"] = (width - width % 2, height - height % 2)
        return {
            "main": stream,
            "lores": lores,
            "raw": raw,
            "sensor": sensor,
            "queue": queue,
            "buffer_count": buffer_count,
            "controls": {"FrameDurationLimits": (33333, 33333), **controls},
        }

    def configure(self, config: dict[str, Any]) -> None:
        if self.is_started:
            raise RuntimeError("Camera must be stopped before configuring")
        if unknown := set(config["sensor"] or {}) - {"bit_depth", "output_size"}:
            raise RuntimeError(f"Unexpected keys {unknown} in sensor configuration")
        assert config["main"]["format"] in CHANNELS
        assert type(config["main"]["size"]) is tuple
        self.config = config
        self.set_controls(config["controls"])

    def set_controls(self, controls: Mapping[str, Any]) -> None:
        for name in controls:
            if name not in self.bench.controls:
                raise RuntimeError(f"Control {name} is not advertised by libcamera")
        self.set |= controls

    def start(self) -> None:
        if not self.config:
            raise RuntimeError("Camera has not been configured")
        self.is_started = True

    def capture_request(self, wait: float | None = None) -> FakeRequest:
        assert self.is_started
        if self.bench.is_hanging or self.outstanding == self.config["buffer_count"]:
            assert wait, "without a timeout this wait would never end"
            raise TimedOutError
        self.outstanding += 1
        return FakeRequest(self, self._metadata())

    def cancel_all_and_flush(self) -> None:
        self.flushes += 1

    def close(self) -> None:
        self.is_closed = True

    def _metadata(self) -> dict[str, Any]:
        is_searching = bool(self._exposures)
        exposure = self._exposures.pop(0) if self._exposures else FOUND_US
        if self.set.get("AeEnable", True):
            exposure = round(exposure / self.lamp)
        metadata: dict[str, Any] = {
            "SensorTimestamp": round((self.bench.clock.monotonic_s - self.bench.latency_s) * 1e9),
            "ExposureTime": self.set.get("ExposureTime", exposure),
            "AnalogueGain": self.set.get("AnalogueGain", FOUND_GAIN),
            "ColourGains": self.set.get("ColourGains", FOUND_GAINS),
        }
        return metadata | (
            {"AeState": 1 if is_searching else 2} if self.bench.is_new else {"AeLocked": not is_searching}
        )


class FakeCamera:
    """The simulated hardware: the cameras, the brightness, and whether captures hang."""

    def __init__(self, clock: LabClock) -> None:
        self.clock = clock
        self.models = ["imx219"]
        self.modes: list[dict[str, Any]] = list(IMX219)
        self.controls: tuple[str, ...] = CONTROLS
        self.lamp = 1.0
        self.latency_s = 0.012
        self.is_busy = self.is_hanging = False
        self.is_new = True
        self.opened: list[FakePicamera2] = []

    @property
    def last(self) -> FakePicamera2:
        return self.opened[-1]

    def module(self) -> ModuleType:
        """Return the module for ``import picamera2``."""
        module = ModuleType("picamera2")
        FakePicamera2.bench = self
        module.Picamera2 = FakePicamera2  # type: ignore[attr-defined]
        return module
