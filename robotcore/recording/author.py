"""Turns what was noted into messages, on the thread that writes."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

from robotcore.description import CameraDescription, RangeSensorDescription
from robotcore.geometry import Pose
from robotcore.hal.devices import Frame
from robotcore.recording import channels
from robotcore.recording.channels import writer_for
from robotcore.recording.events import Glimpse, Raised
from robotcore.recording.frames import (
    BODY,
    ODOMETRY,
    TRUE,
    TRUE_BODY,
    mounted,
    nanoseconds,
    optical,
    placed,
    planar,
    timestamp,
)
from robotcore.recording.mcapfile import McapFile
from robotcore.recording.notes import Notes
from robotcore.recording.recording import Metadata
from robotcore.recording.schemas import END, RESULT, RUN, TICK, TRUTH
from robotcore.recording.story import Level, Line, Story, last_line
from robotcore.recording.ticks import Ticks
from robotcore.recording.wire import plain, to_json
from robotcore.runtime.outcome import RunResult
from robotcore.runtime.session import Run
from robotcore.runtime.trace import TickRecord

if TYPE_CHECKING:
    from foxglove.messages import FrameTransform


TICK_BYTES = 4096
"""What a tick without pictures holds on to, about."""


class Entry(NamedTuple):
    """A tick as it is handed over by the control thread."""

    record: TickRecord
    notes: Notes
    glimpse: Glimpse | None
    error: Raised | None

    @property
    def size(self) -> int:
        """About how many bytes it holds on to."""
        pictures = (sample.image.nbytes for _, sample in self.notes.samples if isinstance(sample, Frame))
        return TICK_BYTES + sum(pictures)


class Author:
    """Writes one run into a file: what it was, its ticks, how it ended."""

    def __init__(self, file: McapFile, run: Run, about: Metadata, *, is_jpeg: bool) -> None:
        from foxglove.channels import FrameTransformsChannel, LogChannel, PoseInFrameChannel

        self._file = file
        self._write = {
            name: write
            for name, device in run.robot.devices.items()
            if (write := writer_for(file, device, is_jpeg=is_jpeg))
        }
        self._write_tick = file.json(channels.TICKS, TICK)
        self._truth = file.json(channels.TRUTH, TRUTH) if run.truth else None
        self._log = LogChannel(channels.LOG, context=file.context)
        self._pose = PoseInFrameChannel(channels.POSE, context=file.context)
        self._moving = FrameTransformsChannel(channels.MOVING, context=file.context)
        self._mounted = FrameTransformsChannel(channels.MOUNTED, context=file.context)
        self._ticks = Ticks(about.description)
        self._story = Story(run.behaviour.milestones, run.faults)
        self._now = 0.0
        self._begin(about)

    def write(self, entry: Entry) -> None:
        """Write a tick, after the samples it was given: where a tick is, they are."""
        self._now = entry.record.time
        for key, sample in entry.notes.samples:
            self._write[key.device](sample, self._now)
        tick = self._ticks.made_of(entry.record, entry.notes, entry.error)
        self._write_tick(to_json(tick), nanoseconds(self._now))
        self._tell(self._story.of(tick))
        if entry.glimpse and self._truth:
            self._truth(to_json(entry.glimpse), nanoseconds(self._now))
        self._place(tick.pose, entry.glimpse)

    def end(self, result: RunResult) -> None:
        """Write how the run ended."""
        self._tell([last_line(result)])
        self._file.json(channels.RESULT, RESULT)(result.to_json().encode(), nanoseconds(self._now))
        self._file.note("robotcore.result", {"outcome": result.outcome.value, "reason": result.reason})

    def end_early(self, why: str) -> None:
        """Write why nothing more comes, though the run goes on."""
        self._tell([Line(Level.Info, why)])
        self._file.json(channels.END, END)(json.dumps({"reason": why}).encode(), nanoseconds(self._now))

    def _begin(self, about: Metadata) -> None:
        from foxglove.messages import FrameTransforms

        self._file.json(channels.RUN, RUN)(to_json(about), 0)
        self._file.note("robotcore.run", _in_words(about))
        self._file.attach("robot.json", "application/json", _readable(about.description))
        if about.world:
            self._file.attach("world.json", "application/json", _readable(about.world))
        if about.source is not None:
            self._file.attach("app.py", "text/x-python", about.source.encode())
        self._mounted.log(FrameTransforms(transforms=list(_fixed(about))), log_time=0)
        self._file.flush()

    def _place(self, believed: Pose | None, glimpse: Glimpse | None) -> None:
        """Write where the robot believes it is, and where it is."""
        from foxglove.messages import FrameTransforms, PoseInFrame

        transforms = []
        if believed:
            told = PoseInFrame(timestamp=timestamp(self._now), frame_id=ODOMETRY, pose=planar(believed))
            self._pose.log(told, log_time=nanoseconds(self._now))
            transforms.append(placed(ODOMETRY, BODY, believed, self._now))
        if glimpse:
            transforms.append(placed(TRUE, TRUE_BODY, glimpse.pose, self._now))
        if transforms:
            self._moving.log(FrameTransforms(transforms=transforms), log_time=nanoseconds(self._now))

    def _tell(self, lines: Iterable[Line]) -> None:
        from foxglove.messages import Log, LogLevel

        for level, text in lines:
            told = Log(
                timestamp=timestamp(self._now), level=getattr(LogLevel, level.name), message=text, name="robotcore"
            )
            self._log.log(told, log_time=nanoseconds(self._now))


def _fixed(about: Metadata) -> Iterator[FrameTransform]:
    """Yield where the run began in the world, where sensors sit on the body, and how their pictures lie."""
    if about.world:
        yield placed(TRUE, ODOMETRY, about.world.start.pose, 0.0)
    for device in about.description.devices:
        if isinstance(device, (CameraDescription, RangeSensorDescription)):
            yield mounted(device.name, device.mount)
        if isinstance(device, CameraDescription):
            yield optical(device.name)


def _in_words(about: Metadata) -> dict[str, str]:
    """Return what people look for first."""
    request = plain(about.request)
    return {name: value if isinstance(value, str) else json.dumps(value) for name, value in request.items()}


def _readable(described: object) -> bytes:
    return json.dumps(plain(described), indent=2).encode()
