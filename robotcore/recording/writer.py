"""Convert the events of a run to messages, on the thread that writes."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

from robotcore.description import CameraDescription, RangeSensorDescription, RobotDescription
from robotcore.geometry import DifferentialGeometry, Pose, Wheels
from robotcore.hal.devices import Frame
from robotcore.hal.drive import Odometry
from robotcore.recording import foxglove as channels
from robotcore.recording.codec import to_json, to_plain
from robotcore.recording.events import GroundTruthSample, RecordedError, Tick, WheelAngles
from robotcore.recording.foxglove import (
    BODY,
    END_SCHEMA,
    ODOMETRY,
    RESULT_SCHEMA,
    RUN_SCHEMA,
    TICK_SCHEMA,
    TRUE,
    TRUE_BODY,
    TRUTH_SCHEMA,
    build_mount_transform,
    build_optical_transform,
    build_transform,
    open_channel,
    to_nanoseconds,
    to_pose_message,
    to_timestamp,
)
from robotcore.recording.layer import TickEvents
from robotcore.recording.log import Level, LogLine, RunLog, build_last_line
from robotcore.recording.mcap_file import McapFile
from robotcore.recording.recording import Metadata
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import Run
from robotcore.runtime.trace import TickRecord

if TYPE_CHECKING:
    from foxglove.messages import FrameTransform


TICK_BYTES = 4096
"""What a tick without pictures holds on to, about."""


class Entry(NamedTuple):
    """A tick as it is handed over by the control thread."""

    record: TickRecord
    events: TickEvents
    truth: GroundTruthSample | None
    error: RecordedError | None

    @property
    def size(self) -> int:
        """About how many bytes it holds on to."""
        pictures = (sample.image.nbytes for _, sample in self.events.samples if isinstance(sample, Frame))
        return TICK_BYTES + sum(pictures)


class RecordingWriter:
    """Writes one run into a file: what it was, its ticks, how it ended."""

    def __init__(self, file: McapFile, run: Run, about: Metadata, *, is_jpeg: bool) -> None:
        from foxglove.channels import FrameTransformsChannel, LogChannel, PoseInFrameChannel

        self._file = file
        self._write = {
            name: write
            for name, device in run.robot.devices.items()
            if (write := open_channel(file, device, is_jpeg=is_jpeg))
        }
        self._write_tick = file.json(channels.TICKS, TICK_SCHEMA)
        self._truth = file.json(channels.TRUTH, TRUTH_SCHEMA) if run.truth else None
        self._log = LogChannel(channels.LOG, context=file.context)
        self._pose = PoseInFrameChannel(channels.POSE, context=file.context)
        self._moving = FrameTransformsChannel(channels.TRANSFORMS, context=file.context)
        self._mounted = FrameTransformsChannel(channels.STATIC_TRANSFORMS, context=file.context)
        self._tick_builder = TickBuilder(about.description)
        self._run_log = RunLog(run.behaviour.milestones, run.faults)
        self._now = 0.0
        self._begin(about)

    def write(self, entry: Entry) -> None:
        """Write a tick, after the samples it was given: where a tick is, they are."""
        self._now = entry.record.time
        for key, sample in entry.events.samples:
            self._write[key.device](sample, self._now)
        tick = self._tick_builder.build(entry.record, entry.events, entry.error)
        self._write_tick(to_json(tick), to_nanoseconds(self._now))
        self._write_log(self._run_log.list_new(tick))
        if entry.truth and self._truth:
            self._truth(to_json(entry.truth), to_nanoseconds(self._now))
        self._write_poses(tick.pose, entry.truth)

    def end(self, result: RunResult) -> None:
        """Write how the run ended."""
        self._write_log([build_last_line(result)])
        self._file.json(channels.RESULT, RESULT_SCHEMA)(result.to_json().encode(), to_nanoseconds(self._now))
        self._file.write_metadata("robotcore.result", {"outcome": result.outcome.value, "reason": result.reason})

    def end_early(self, why: str) -> None:
        """Write why nothing more comes, though the run goes on."""
        self._write_log([LogLine(Level.Info, why)])
        self._file.json(channels.END, END_SCHEMA)(json.dumps({"reason": why}).encode(), to_nanoseconds(self._now))

    def _begin(self, about: Metadata) -> None:
        from foxglove.messages import FrameTransforms

        self._file.json(channels.RUN, RUN_SCHEMA)(to_json(about), 0)
        self._file.write_metadata("robotcore.run", _format_request(about))
        self._file.attach("robot.json", "application/json", _to_readable_json(about.description))
        if about.world:
            self._file.attach("world.json", "application/json", _to_readable_json(about.world))
        if about.source is not None:
            self._file.attach("app.py", "text/x-python", about.source.encode())
        self._mounted.log(FrameTransforms(transforms=list(_build_static_transforms(about))), log_time=0)
        self._file.flush()

    def _write_poses(self, odometry_pose: Pose | None, truth: GroundTruthSample | None) -> None:
        """Write where the robot believes it is, and where it is."""
        from foxglove.messages import FrameTransforms, PoseInFrame

        transforms = []
        if odometry_pose:
            message = PoseInFrame(
                timestamp=to_timestamp(self._now), frame_id=ODOMETRY, pose=to_pose_message(odometry_pose)
            )
            self._pose.log(message, log_time=to_nanoseconds(self._now))
            transforms.append(build_transform(ODOMETRY, BODY, odometry_pose, self._now))
        if truth:
            transforms.append(build_transform(TRUE, TRUE_BODY, truth.pose, self._now))
        if transforms:
            self._moving.log(FrameTransforms(transforms=transforms), log_time=to_nanoseconds(self._now))

    def _write_log(self, lines: Iterable[LogLine]) -> None:
        from foxglove.messages import Log, LogLevel

        for level, text in lines:
            message = Log(
                timestamp=to_timestamp(self._now), level=getattr(LogLevel, level.name), message=text, name="robotcore"
            )
            self._log.log(message, log_time=to_nanoseconds(self._now))


def _build_static_transforms(about: Metadata) -> Iterator[FrameTransform]:
    """Yield where the run began in the world, where sensors sit on the body, and how their pictures lie."""
    if about.world:
        yield build_transform(TRUE, ODOMETRY, about.world.start.pose, 0.0)
    for device in about.description.devices:
        if isinstance(device, (CameraDescription, RangeSensorDescription)):
            yield build_mount_transform(device.name, device.mount)
        if isinstance(device, CameraDescription):
            yield build_optical_transform(device.name)


def _format_request(about: Metadata) -> dict[str, str]:
    """Return what people look for first."""
    request = to_plain(about.request)
    return {name: value if isinstance(value, str) else json.dumps(value) for name, value in request.items()}


def _to_readable_json(described: object) -> bytes:
    return json.dumps(to_plain(described), indent=2).encode()


class TickBuilder:
    """The ticks of one run, made in turn."""

    def __init__(self, description: RobotDescription) -> None:
        self._odometry = OdometryTracker(description.drive.geometry) if description.drive else None

    def build(self, record: TickRecord, events: TickEvents, error: RecordedError | None) -> Tick:
        """Return a tick as it is recorded; ``error`` is what ended the run in it."""
        return Tick(
            number=record.tick,
            time=record.time,
            state=record.state,
            reads=tuple(events.reads),
            asks=tuple(events.asks),
            motor_asks=tuple(events.motor_asks),
            turned=tuple(events.turned),
            standing=tuple(events.standing),
            pose=self._odometry.after(events.turned) if self._odometry and events.turned else None,
            asked=record.asked,
            sent=record.sent,
            interventions=record.interventions,
            commit_error=events.commit_error,
            shown=tuple(events.shown),
            error=error,
            warnings=record.warnings,
        )


class OdometryTracker:
    """Where the wheels' angles took the robot: the drive's own odometry, over the angles that it read."""

    def __init__(self, geometry: DifferentialGeometry) -> None:
        self._angles = Wheels(0.0, 0.0)
        self._odometry = Odometry(geometry, lambda: self._angles)
        self._pose = Pose(0.0, 0.0, 0.0)

    def after(self, turned: Iterable[WheelAngles]) -> Pose:
        """Return the pose after what the odometry read in a tick."""
        for each in turned:
            if each.angles:
                self._angles = each.angles
                self._pose = self._odometry.pose()
        return self._pose
