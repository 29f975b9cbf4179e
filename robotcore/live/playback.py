"""A recording for the live page: its messages at each tick."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from robotcore.errors import RecordingError
from robotcore.hal.device import Sample, Sensor
from robotcore.hal.kind import build_sensor, load_kind
from robotcore.kinds.camera import Frame
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.operator import OperatorSample
from robotcore.live.messages import to_json
from robotcore.live.recording_index import RecordingIndex
from robotcore.live.run_description import describe_device, draw_world, measure_bounds
from robotcore.live.snapshot import WheelSpeeds, describe_sample, list_velocities
from robotcore.optics import Image
from robotcore.recording import SampleKey, read
from robotcore.recording.summary import explain_missing_end
from robotcore.runtime.apps import app_name

CACHED_PICTURES = 4
"""The number of pictures in memory. Each holds a part of the file with it."""

PLOT_S = 20.0
"""The time that the page's plot of the wheels shows, in seconds."""

MAX_PLOT_POINTS = 200
"""The greatest number of velocities that a seek sends for the plot."""

SPEED_TICKS = 6
"""The number of ticks from which the velocities of the wheels are measured."""


class Playback:
    """A recording in the messages of the live page.

    Pictures are read from the file when they are shown.

    path: the file. Raises RecordingError if it is not a recording, or has no tick.
    name: the name that the page shows.
    """

    def __init__(self, path: Path, name: str) -> None:
        self.name = name
        self._recording = recording = read(path)
        if not recording.ticks:
            raise RecordingError(
                path, "the recording has no tick", "Record the run again", kind="recording-without-ticks"
            )
        metadata, self._ticks = recording.metadata, recording.ticks
        self.times = [tick.time for tick in self._ticks]
        """The time of each tick, in seconds on the robot's clock."""
        self._devices = [each for each in metadata.description.devices if each.name in metadata.devices]
        self._sensors: dict[str, Sensor[Any]] = {}
        for each in self._devices:
            if issubclass(load_kind(each.kind).device, Sensor):
                self._sensors[each.name] = sensor = build_sensor(each, lambda: None)
                each.configure(sensor)
        self._cameras = [each.name for each in self._devices if each.kind == "camera"]
        self._index = RecordingIndex(recording, self._cameras)
        self._read_frame = lru_cache(CACHED_PICTURES)(recording.samples.__getitem__)
        self.problems = list(self._list_problems())
        """The parts that the recording lacks, as sentences."""

    def find(self, time: float) -> int:
        """Return the place of the last tick at a time or before; 0 before the first one."""
        return max(0, bisect_right(self.times, time + 1e-9) - 1)

    def describe(self) -> dict[str, Any]:
        """Return the message that describes the run."""
        metadata = self._recording.metadata
        request, description = metadata.request, metadata.description
        return {
            "type": "run",
            "app": app_name(request.app_reference),
            "backend": request.backend,
            "robot": description.name,
            "world": metadata.world.name if metadata.world else None,
            "seed": request.seed,
            "rate": request.rate_hz,
            "is_simulated": metadata.is_stepped,
            "milestones": list(metadata.milestones),
            "faults": list(request.faults),
            "devices": [describe_device(each, description) for each in self._devices],
            "footprint": [list(corner) for corner in description.body.footprint],
            "bounds": measure_bounds(metadata.world if self._index.truth else None),
            "drive": self._describe_drive(),
            "can_pace": False,
            "has_operator": False,
            "actuators": [],
        }

    def draw_world(self) -> Image | None:
        """Return the picture of the world from above; None if no simulator measured the poses."""
        return draw_world(self._recording.metadata.world if self._index.truth else None)

    def build_tick(self, at: int, since: int) -> dict[str, Any]:
        """Return the message of a tick, without its pictures.

        since: the place of the first tick whose points of the path and velocities of the wheels the message has.
        """
        tick, index = self._ticks[at], self._index
        logged = {name: newest for name, series in index.logged.items() if (newest := series.find(at))}
        return {
            "type": "tick",
            "tick": tick.number,
            **self._describe_wheels(at),
            "state": tick.state,
            "milestones": {name: time for name, time in index.milestones.items() if time <= tick.time},
            "pose": to_json(tick.pose),
            "truth": to_json(index.truth.get(tick.number)),
            "path": self.list_path(since, at),
            "wheels": [self._describe_wheels(each) for each in range(since, at)],
            "devices": dict(self._list_devices(at)),
            "logged": {name: {"value": to_json(value), "unit": unit} for name, (value, unit) in logged.items()},
            "interventions": [each.cause for each in tick.interventions],
            "is_hand_driven": self._is_hand_driven(at),
            "pace": None,
            "overruns": 0,
            "faults": [str(fault) for fault in index.faults if fault.is_active(tick.time)],
        }

    def list_path(self, since: int, at: int) -> list[tuple[float, float, str]]:
        """Return the points of the path from one tick to another."""
        return self._index.path.list_between(since, at)

    def list_lines(self, since: int, at: int) -> list[dict[str, Any]]:
        """Return the log lines from one tick to another."""
        return self._index.lines.list_between(since, at)

    def list_wheels(self, at: int) -> list[dict[str, Any]]:
        """Return the velocities of the wheels before a tick, for the plot."""
        begin = self.find(self.times[at] - PLOT_S)
        return [self._describe_wheels(each) for each in range(begin, at, 1 + (at - begin) // MAX_PLOT_POINTS)]

    def list_pictures(self, at: int) -> Iterator[tuple[str, SampleKey | None]]:
        """Yield the name of each camera and each display, and the key of its newest picture; None without one."""
        for name, series in self._index.pictures.items():
            yield name, series.find(at)

    def read_picture(self, key: SampleKey) -> Image:
        """Return a picture. Raises RecordingError if the file is damaged there."""
        frame = self._read_sample(key)
        assert isinstance(frame, Frame)
        return frame.image

    def _describe_wheels(self, at: int) -> dict[str, Any]:
        tick = self._ticks[at]
        return {
            "time": round(tick.time, 3),
            "asked": to_json(tick.asked),
            "sent": to_json(tick.sent),
            "measured": self._measure_wheels(at),
        }

    def _describe_drive(self) -> dict[str, Any] | None:
        description = self._recording.metadata.description
        if (drive := description.drive) is None:
            return None
        motors = {*drive.left_motors, *drive.right_motors}
        wheel = min(each.max_velocity_rad_s for each in description.all_of(MotorDescription) if each.name in motors)
        linear = wheel * drive.geometry.wheel_radius
        return {
            "linear": linear,
            "angular": 2 * linear / drive.geometry.track,
            "wheel": wheel,
            "is_measured": bool(drive.left_encoders),
        }

    def _list_problems(self) -> Iterator[str]:
        recording, first = self._recording, self._ticks[0]
        if missing := explain_missing_end(recording):
            yield missing
        elif recording.damage:
            yield f"the file is damaged ({recording.damage})"
        elif recording.is_cut:
            yield "the end of the file is missing"
        if first.number:
            yield f"the recording begins at {first.time:.1f} s"
        if self._index.dropped:
            yield f"{self._index.dropped} pictures were dropped, because the disk was too slow"
        for name in self._cameras:
            if name not in self._index.pictures:
                yield f"no picture of {name}"

    def _read_sample(self, key: SampleKey) -> Sample:
        is_picture = key.device in self._index.pictures
        return self._read_frame(key) if is_picture else self._recording.samples[key]

    def _list_devices(self, at: int) -> Iterator[tuple[str, dict[str, Any]]]:
        tick, description = self._ticks[at], self._recording.metadata.description
        for name, sensor in self._sensors.items():
            if (samples := self._index.samples.get(name)) and (key := samples.find(at)):
                with suppress(RecordingError):  # a damaged picture
                    yield name, describe_sample(sensor, self._read_sample(key), tick.time)
        for name, series in self._index.commands.items():
            if (newest := series.find(at)) is not None:
                command = to_json(list(newest.values()) if isinstance(newest, dict) else newest)
                yield name, {"values": {"command": command}, "text": str(command)}
        if tick.sent and (drive := description.drive):
            for device in self._devices:
                if velocities := list_velocities(device.name, drive.left_motors, drive.right_motors, tick.sent):
                    velocity = sum(velocities) / len(velocities)
                    yield device.name, {"values": {"command": to_json(velocity)}, "text": f"{velocity:.2f} rad/s"}

    def _is_hand_driven(self, at: int) -> bool:
        for name in (each.name for each in self._devices if each.kind == "operator"):
            if (samples := self._index.samples.get(name)) and (key := samples.find(at)):
                sample = self._read_sample(key)
                return isinstance(sample, OperatorSample) and sample.is_driving
        return False

    def _measure_wheels(self, at: int) -> Any:
        drive = self._recording.metadata.description.drive
        if drive is None or not drive.left_encoders:
            return None
        speeds, measured = WheelSpeeds(drive.left_encoders, drive.right_encoders), None
        names = [each for each in (*drive.left_encoders, *drive.right_encoders) if each in self._index.samples]
        for tick in range(max(0, at - SPEED_TICKS), at + 1):
            keys = {name: self._index.samples[name].find(tick) for name in names}
            measured = speeds.measure({name: self._read_sample(key) for name, key in keys.items() if key})
        return to_json(measured)


def draw_missing_picture() -> Image:
    """Return the grey picture that stands for a camera or a display before its first picture."""
    image = np.full((240, 320, 3), 128, np.uint8)
    white, font = (255, 255, 255), cv2.FONT_HERSHEY_SIMPLEX
    return np.asarray(cv2.putText(image, "no picture yet", (95, 125), font, 0.55, white, 1, cv2.LINE_AA), np.uint8)
