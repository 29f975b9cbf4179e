"""Read the measurements of a recorded run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from robotcore.description import Drive, RobotDescription
from robotcore.errors import RecordingError
from robotcore.fidelity.run_data import (
    SIDES,
    AngleSeries,
    Array,
    PictureSeries,
    RangeSeries,
    RunData,
    list_ray_sensors,
    read_distances,
    unwrap,
)
from robotcore.geometry import Pose, Wheels
from robotcore.kinds.camera import Frame
from robotcore.kinds.encoder import EncoderDescription
from robotcore.recording import Recording, SampleKey, Tick
from robotcore.recording.summary import build_true_path, is_plausible

MAX_PICTURES = 100
"""The maximum number of pictures of a camera that are compared. They are spread over the run."""


MAX_DISTANCE_M = 1000.0
"""A longer distance, except an infinite one, is no measurement, in metres."""

MAX_ANGLE_RAD = 1e9
"""A greater angle of an encoder is no measurement, in radians."""


class PathSource(str, Enum):
    """The source of the real path."""

    TRUTH = "truth"
    """The simulator of the recorded run measured the true poses."""
    ODOMETRY = "odometry"
    """The path is computed from the recorded angles of the wheels."""
    NONE = "none"
    """The path is unknown: the recording has no measured angles of the wheels."""


@dataclass(frozen=True, eq=False)
class RecordedData:
    """The measurements of a recorded run, and the source of its path."""

    run: RunData
    source: PathSource
    left_out: Mapping[str, int]
    """The number of impossible samples that are left out, by the name of the sensor."""
    lost_poses: int = 0
    """The number of impossible true poses that are left out."""


def read_recorded(recording: Recording, ticks: Sequence[Tick], robot: RobotDescription, start: Pose) -> RecordedData:
    """Return the measurements of a recorded run.

    ticks: the first ticks of the recording, up to the last one that counts.
    robot: the best description of the robot. Its wheels convert recorded angles to the path by odometry.
    start: the pose of the robot at the start of a run whose true path is unknown.
    """
    times = np.array([tick.time - ticks[0].time for tick in ticks])
    source, poses = _find_poses(recording, ticks, robot, start)
    recorded = recording.metadata.description
    left_out: Counter[str] = Counter()
    data = RunData(times, unwrap(poses), _read_angles(recording, ticks, robot, left_out))
    fields = list_ray_sensors(recorded)
    cameras = {camera.name: camera.width_px for camera in recorded.all_of("camera")}
    for name, distance_field in fields.items():
        if series := _read_ranges(recording, ticks, name, distance_field, left_out):
            data.ranges[name] = series
    for name, width_px in cameras.items():
        if pictures := _read_pictures(recording, ticks, name, width_px):
            data.pictures[name] = pictures
    counted = [sample.contacts for sample in recording.truth if sample.tick <= ticks[-1].number]
    data.contacts = counted[-1] if counted else None
    lost = sum(not is_plausible(each.pose) for each in recording.truth if each.tick <= ticks[-1].number)
    return RecordedData(data, source, left_out, lost)


def _are_possible(distances: Array) -> bool:
    return bool(np.all((distances >= 0) & ((distances <= MAX_DISTANCE_M) | np.isinf(distances))))


def _find_poses(
    recording: Recording, ticks: Sequence[Tick], robot: RobotDescription, start: Pose
) -> tuple[PathSource, list[Pose | None]]:
    if truth := build_true_path(recording):
        return PathSource.TRUTH, [truth.get(tick.number) for tick in ticks]
    if not _has_encoders(recording):
        return PathSource.NONE, [None] * len(ticks)
    poses = [pose and start.compose(pose) for pose in _compute_odometry(recording, ticks, robot)]
    return PathSource.ODOMETRY, [pose if pose and is_plausible(pose) else None for pose in poses]


def _has_encoders(recording: Recording) -> bool:
    drive = recording.metadata.description.drive
    return drive is not None and bool(drive.encoders) and set(drive.encoders) <= set(recording.metadata.devices)


def _compute_odometry(recording: Recording, ticks: Sequence[Tick], robot: RobotDescription) -> Iterator[Pose | None]:
    """Yield the pose by odometry at each tick, from the first tick on."""
    recorded = recording.metadata.description
    assert recorded.drive
    assert robot.drive
    left, right = (_compute_scale(recorded, robot, side) for side in SIDES)
    geometry, pose = robot.drive.geometry, Pose(0.0, 0.0, 0.0)
    last: Wheels | None = None
    for tick in ticks:
        measured = [each for each in tick.turned if each.angles]
        for each in measured:
            for angles in (*getattr(each, "between", ()), each.angles):
                before, last = last or angles, angles
                turned = Wheels((angles.left - before.left) * left, (angles.right - before.right) * right)
                pose = pose.advance(*geometry.to_twist(turned))
        yield pose if measured else None


def _compute_scale(recorded: RobotDescription, robot: RobotDescription, side: str) -> float:
    """Return the factor from a recorded angle to that of an encoder with the counts in another description."""
    counts = [_count_turn(each, side) for each in (recorded, robot)]
    return counts[0] / counts[1] if all(counts) else 1.0


def _count_turn(robot: RobotDescription, side: str) -> int:
    names = _list_encoders(robot.drive, side) if robot.drive else ()
    found = {each.name: each.counts_per_turn for each in robot.all_of(EncoderDescription)}
    return found[names[0]] if names else 0


def _list_encoders(drive: Drive, side: str) -> tuple[str, ...]:
    return drive.left_encoders if side == SIDES[0] else drive.right_encoders


def _read_angles(
    recording: Recording, ticks: Sequence[Tick], robot: RobotDescription, left_out: Counter[str]
) -> dict[str, AngleSeries]:
    """Return the angles of both sides, from the samples of the encoders, else from those that the odometry read.

    left_out: the counts of impossible samples, to which these are added.
    """
    recorded = recording.metadata.description
    if not _has_encoders(recording) or recorded.drive is None:
        return {}
    scales = {side: _compute_scale(recorded, robot, side) for side in SIDES}
    found = {side: _read_encoders(recording, ticks, _list_encoders(recorded.drive, side), left_out) for side in SIDES}
    if not all(found.values()):
        found = _read_odometry_angles(ticks)
    return {side: AngleSeries(each.times, each.angles * scales[side]) for side, each in found.items() if each}


def _read_encoders(
    recording: Recording, ticks: Sequence[Tick], names: Sequence[str], left_out: Counter[str]
) -> AngleSeries | None:
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in names}
    for _, key in _list_new_samples(recording, ticks, names):
        sample = recording.samples[key]
        angle = getattr(sample, "angle", np.nan)
        if abs(angle) <= MAX_ANGLE_RAD:
            found[key.device].append((sample.time - ticks[0].time, angle))
        else:
            left_out[key.device] += 1
    if not names or min(map(len, found.values())) < 2:
        return None
    return AngleSeries.mean([AngleSeries(*np.array(sorted(pairs)).T) for pairs in found.values()])


def _read_odometry_angles(ticks: Sequence[Tick]) -> dict[str, AngleSeries | None]:
    pairs = [(tick.time - ticks[0].time, each.angles) for tick in ticks for each in tick.turned[-1:] if each.angles]
    if len(pairs) < 2:
        return {}
    times, angles = np.array([time for time, _ in pairs]), np.array([angles for _, angles in pairs])
    return {side: AngleSeries(times, angles[:, index]) for index, side in enumerate(SIDES)}


def _list_new_samples(
    recording: Recording, ticks: Sequence[Tick], devices: Sequence[str]
) -> Iterator[tuple[int, SampleKey]]:
    """Yield the index of the tick and the key of each new sample of these devices that the recording has."""
    last: dict[str, SampleKey] = {}
    for index, tick in enumerate(ticks):
        for read in tick.reads:
            if read.device in devices and (key := read.key) in recording.samples and last.get(read.device) != key:
                assert key
                last[read.device] = key
                yield index, key


def _read_ranges(
    recording: Recording, ticks: Sequence[Tick], name: str, distance_field: str, left_out: Counter[str]
) -> RangeSeries | None:
    series = RangeSeries()
    for index, key in _list_new_samples(recording, ticks, (name,)):
        sample = recording.samples[key]
        distances = read_distances(sample, distance_field)
        if _are_possible(distances):
            series.add(index, distances, sample.time - ticks[0].time)
        else:
            left_out[name] += 1
    series.reads = [index for index, tick in enumerate(ticks) if any(read.device == name for read in tick.reads)]
    return series if series.times else None


def _read_pictures(recording: Recording, ticks: Sequence[Tick], name: str, width_px: int) -> PictureSeries | None:
    samples, series = list(_list_new_samples(recording, ticks, (name,))), PictureSeries(width_px)
    for place in np.linspace(0, len(samples) - 1, min(len(samples), MAX_PICTURES)).astype(int):
        index, key = samples[place]
        try:
            frame = recording.samples[key]
        except RecordingError:  # a damaged picture is left out
            continue
        if isinstance(frame, Frame) and min(frame.image.shape[:2]) > 1:
            series.add(index, frame.image)
    return series if series.pictures else None
