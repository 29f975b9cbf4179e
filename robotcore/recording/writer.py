"""Write a run to its file, in the writer thread: metadata, ticks, samples and result."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

from robotcore.description import RobotDescription
from robotcore.geometry import Pose, Wheels
from robotcore.hal.drive import Odometry, WheelPath
from robotcore.kinds.camera import Camera, Frame
from robotcore.recording import foxglove_channels as channels
from robotcore.recording.channel_output import ChannelOutput
from robotcore.recording.codec import to_json, to_plain
from robotcore.recording.event_log import Level, LogLine, RunLog, build_last_line
from robotcore.recording.events import GroundTruthSample, RecordedError, Tick
from robotcore.recording.foxglove_channels import (
    BODY_FRAME,
    ODOMETRY_FRAME,
    TRUE_BODY_FRAME,
    TRUTH_FRAME,
    build_optical_name,
    build_pose_transform,
    build_transform,
    open_calibration,
    open_channel,
    to_nanoseconds,
    to_pose_message,
    to_timestamp,
)
from robotcore.recording.logged_values import LoggedValueWriter
from robotcore.recording.recording import Metadata
from robotcore.recording.tap import TickEvents
from robotcore.runtime.result import RunResult
from robotcore.runtime.session import RunContext
from robotcore.runtime.trace import TickRecord

if TYPE_CHECKING:
    from foxglove.messages import FrameTransform


TICK_BYTES, LOGGED_BYTES = 4096, 256
"""The assumed sizes of a tick without pictures, and of a logged value or a printed line, in bytes."""


class Entry(NamedTuple):
    """The record of one tick. The control thread puts it into a queue, and the writer thread takes it out."""

    record: TickRecord
    events: TickEvents
    truth: GroundTruthSample | None
    error: RecordedError | None

    @property
    def size(self) -> int:
        """The approximate size in memory, in bytes."""
        pictures = (sample.image.nbytes for _, sample in self.events.samples if isinstance(sample, Frame))
        record = self.record
        return TICK_BYTES + LOGGED_BYTES * (len(record.logged) + len(record.printed)) + sum(pictures)


class RecordingWriter:
    """Writes one run to a file, or to the clients of a server. It writes the metadata when it is created.

    notes: the list to which the writer adds sentences about the content that the file lacks.
    """

    def __init__(
        self, output: ChannelOutput, run: RunContext, metadata: Metadata, *, is_jpeg: bool, notes: list[str]
    ) -> None:
        from foxglove.channels import FrameTransformsChannel, LogChannel, PoseInFrameChannel

        self._output, self._notes = output, notes
        self._write = {
            name: write
            for name, device in run.robot.devices.items()
            if (write := open_channel(output, device, is_jpeg=is_jpeg, warn=self._warn))
        }
        cameras = (device for device in run.robot.devices.values() if isinstance(device, Camera))
        self._calibrations = [open_calibration(output, camera) for camera in cameras]
        self._metadata, self._write_run = metadata, output.open_json_channel(channels.RUN, channels.RUN_SCHEMA)
        self._write_tick = output.open_json_channel(channels.TICKS, channels.TICK_SCHEMA)
        self._truth: Callable[[bytes, int], None] | None = None
        self._logged = LoggedValueWriter(output)
        self._log = LogChannel(channels.LOG, context=output.context)
        self._pose = PoseInFrameChannel(channels.POSE, context=output.context)
        self._moving = FrameTransformsChannel(channels.TRANSFORMS, context=output.context)
        self._mounted = FrameTransformsChannel(channels.STATIC_TRANSFORMS, context=output.context)
        self._tick_builder = TickBuilder(metadata.description)
        self._run_log = RunLog(run.behaviour.milestones, run.faults)
        self._now = 0.0
        self.describe_run(0.0)
        self._attach(metadata)

    def describe_run(self, time: float) -> None:
        """Write the messages that do not change: the metadata, the mounts of the devices, and the calibrations.

        time: the time of the messages, in seconds.
        """
        from foxglove.messages import FrameTransforms

        self._write_run(to_json(self._metadata), to_nanoseconds(time))
        mounts = FrameTransforms(transforms=list(_build_static_transforms(self._metadata)))
        self._mounted.log(mounts, log_time=to_nanoseconds(time))
        for write_calibration in self._calibrations:
            write_calibration(time)

    def write(self, entry: Entry) -> None:
        """Write the samples and the logged values of a tick, then the tick.

        So a tick in a cut file has all of them.
        """
        self._now = entry.record.time
        for key, sample in entry.events.samples:
            self._write[key.device](sample, self._now)
        self._logged.write(entry.record)
        tick = self._tick_builder.build(entry.record, entry.events, entry.error)
        self._write_tick(to_json(tick), to_nanoseconds(self._now))
        self._write_log(self._run_log.list_new(tick))
        self._write_log((LogLine(Level.Info, line) for line in entry.record.printed), channels.APP)
        if entry.truth:
            self._truth = self._truth or self._output.open_json_channel(channels.TRUTH, channels.TRUTH_SCHEMA)
            self._truth(to_json(entry.truth), to_nanoseconds(self._now))
        self._write_poses(tick.pose, entry.truth)

    def end(self, result: RunResult) -> None:
        """Write the result of the run, and the last log line."""
        self._write_log([build_last_line(result)])
        self._output.open_json_channel(channels.RESULT, channels.RESULT_SCHEMA)(
            result.to_json().encode(), to_nanoseconds(self._now)
        )
        self._output.write_metadata("robotcore.result", {"outcome": result.outcome.value, "reason": result.reason})

    def end_early(self, why: str) -> None:
        """Write the reason why the recording ends before its run."""
        self._write_log([LogLine(Level.Info, why)])
        self._output.open_json_channel(channels.END, channels.END_SCHEMA)(
            json.dumps({"reason": why}).encode(), to_nanoseconds(self._now)
        )

    def _attach(self, metadata: Metadata) -> None:
        self._output.write_metadata("robotcore.run", _format_request(metadata))
        self._output.attach("robot.json", "application/json", _to_readable_json(metadata.description))
        if metadata.world:
            self._output.attach("world.json", "application/json", _to_readable_json(metadata.world))
        if metadata.source is not None:
            self._output.attach("app.py", "text/x-python", metadata.source.encode())
        self._output.flush()

    def _write_poses(self, odometry_pose: Pose | None, truth: GroundTruthSample | None) -> None:
        from foxglove.messages import FrameTransforms, PoseInFrame

        transforms = []
        if odometry_pose:
            message = PoseInFrame(
                timestamp=to_timestamp(self._now), frame_id=ODOMETRY_FRAME, pose=to_pose_message(odometry_pose)
            )
            self._pose.log(message, log_time=to_nanoseconds(self._now))
            transforms.append(build_pose_transform(ODOMETRY_FRAME, BODY_FRAME, odometry_pose, self._now))
        if truth:
            transforms.append(build_pose_transform(TRUTH_FRAME, TRUE_BODY_FRAME, truth.pose, self._now))
        if transforms:
            self._moving.log(FrameTransforms(transforms=transforms), log_time=to_nanoseconds(self._now))

    def _warn(self, text: str) -> None:
        self._notes.append(text)
        self._write_log([LogLine(Level.Warning, text)])

    def _write_log(self, lines: Iterable[LogLine], source: str = channels.FRAMEWORK) -> None:
        from foxglove.messages import Log, LogLevel

        for level, text in lines:
            message = Log(
                timestamp=to_timestamp(self._now), level=getattr(LogLevel, level.name), message=text, name=source
            )
            self._log.log(message, log_time=to_nanoseconds(self._now))


def _build_static_transforms(metadata: Metadata) -> Iterator[FrameTransform]:
    if metadata.world:
        yield build_pose_transform(TRUTH_FRAME, ODOMETRY_FRAME, metadata.world.start.pose, 0.0)
    for device in metadata.description.devices:
        if mount := metadata.description.mounts.get(device.name):
            turn = (0.0, mount.pitch_rad, mount.yaw_rad)
            yield build_transform(BODY_FRAME, device.name, (mount.x_m, mount.y_m, mount.z_m), turn)
        if device.kind == "camera":
            turn = (-math.pi / 2, 0.0, -math.pi / 2)
            yield build_transform(device.name, build_optical_name(device.name), (0.0, 0.0, 0.0), turn)


def _format_request(metadata: Metadata) -> dict[str, str]:
    request = to_plain(metadata.request)
    return {name: value if isinstance(value, str) else json.dumps(value) for name, value in request.items()}


def _to_readable_json(description: object) -> bytes:
    return json.dumps(to_plain(description), indent=2).encode()


class TickBuilder:
    """Builds the recorded ticks of a run, one after the other, with the poses of the odometry."""

    def __init__(self, description: RobotDescription) -> None:
        self._path, self._pose = WheelPath(Wheels(0.0, 0.0)), Pose(0.0, 0.0, 0.0)
        drive = description.drive
        self._odometry = Odometry(drive.geometry, lambda: self._path) if drive else None

    def build(self, record: TickRecord, events: TickEvents, error: RecordedError | None) -> Tick:
        """Return the recorded tick. ``error`` is the error that ends the run in this tick, or None."""
        for turned in events.turned:
            if turned.path and self._odometry:
                self._path = turned.path
                self._pose = self._odometry.pose()
        return Tick(
            number=record.tick,
            time=record.time,
            state=record.state,
            reads=tuple(events.reads),
            asks=tuple(events.asks),
            motor_asks=tuple(events.motor_asks),
            turned=tuple(events.turned),
            pose=self._pose if self._odometry and events.turned else None,
            asked=record.asked,
            sent=record.sent,
            interventions=record.interventions,
            commit_error=events.commit_error,
            shown=tuple(events.shown),
            commands=tuple(events.commands),
            error=error,
            warnings=record.warnings,
        )
