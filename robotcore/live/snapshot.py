"""The snapshot of a tick for the page: poses, wheels, devices, interventions and faults."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from robotcore.errors import describe_exception
from robotcore.geometry import Pose, Wheels
from robotcore.hal.device import Sensor, list_values
from robotcore.hal.robot import Role
from robotcore.hal.value_log import NOTHING_LOGGED, LoggedValue
from robotcore.kinds.camera import Frame
from robotcore.live.messages import to_json
from robotcore.optics import Image, is_picture
from robotcore.recording.summary import is_plausible
from robotcore.runtime.layers.devices import AppActuator, AppMotor, AppSensor
from robotcore.runtime.observer import RunContext
from robotcore.runtime.pace import PaceControl
from robotcore.runtime.trace import TickRecord

MAX_RAYS = 400
"""The page draws at most this number of rays of a sample."""

MAX_NUMBERS = 64
"""A tuple with more numbers has only its text on the page."""

SPEED_WINDOW_S = 0.1
"""The shortest time over which a wheel's velocity is measured, in seconds."""


PATH_STEP_M = 0.02
"""The path has a point after each such distance, in metres."""

MAX_NEW_POINTS = 5000
"""The number of points of the path that wait for the page. Older ones are lost."""


class Snapshot(NamedTuple):
    """The state of a run at the end of a tick. Its parts do not change later."""

    record: TickRecord
    pose: Pose | None
    """The pose by odometry; None for a robot without a drive."""
    truth: Pose | None
    """The true pose in a simulator; None on a real robot."""
    samples: Mapping[str, Any]
    """The last sample of each sensor that the app has read, by name."""
    commands: Mapping[str, Any]
    """The newest command to each actuator other than motors, by name."""
    logged: Mapping[str, LoggedValue]
    """The newest values that the app has logged, by name."""


class SnapshotBuilder:
    """Builds the snapshots of a run, and the messages of the snapshots.

    `take` belongs to the loop and is short. The other methods belong to the thread that sends.
    """

    def __init__(self, run: RunContext) -> None:
        self._run = run
        self._sensors = [each for each in run.robot.devices.values() if isinstance(each, AppSensor)]
        self._actuators = [each for each in run.robot.devices.values() if isinstance(each, AppActuator)]
        self._drive = run.robot.drive if run.robot.has(Role.DRIVE) else None
        drive = run.description.drive
        self._speeds = WheelSpeeds(drive.left_encoders, drive.right_encoders) if drive else None
        self._milestones: dict[str, float] = {}
        self._new_path: deque[tuple[float, float, str]] = deque(maxlen=MAX_NEW_POINTS)
        self._path_end: Pose | None = None
        self._logged: Mapping[str, LoggedValue] = NOTHING_LOGGED

    def take(self, record: TickRecord) -> Snapshot:
        """Return the present state of the run. This reads no device."""
        state = record.state
        truth = self._run.truth.pose if self._run.truth else None
        pose = self._drive.latest_pose if self._drive else None
        self._extend_path(truth or pose, state)
        if record.logged:
            self._logged = {**self._logged, **record.logged}
        if state not in self._milestones and state in self._run.behaviour.milestones:
            self._milestones[str.__str__(state)] = record.time
        return Snapshot(
            record,
            pose,
            truth,
            {each.name: each.latest for each in self._sensors if each.latest is not None},
            {each.name: each.latest for each in self._actuators if each.latest is not None},
            self._logged,
        )

    def _extend_path(self, pose: Pose | None, state: str) -> None:
        last = self._path_end
        if pose and is_plausible(pose) and (last is None or pose.distance_to(last.x, last.y) >= PATH_STEP_M):
            self._path_end = pose
            self._new_path.append((round(pose.x, 4), round(pose.y, 4), str.__str__(state)))

    def _take_path(self) -> list[tuple[float, float, str]]:
        """Return the points of the path since the last call."""
        return [self._new_path.popleft() for _ in range(len(self._new_path))]

    def build_message(self, snapshot: Snapshot, causes: Sequence[str]) -> dict[str, Any]:
        """Return the message of a snapshot, without its pictures.

        causes: the causes of the interventions since the last message.
        """
        record = snapshot.record
        return {
            "type": "tick",
            "tick": record.tick,
            "time": round(record.time, 3),
            "state": record.status_text,
            "milestones": to_json(self._milestones.copy()),
            "pose": to_json(snapshot.pose),
            "truth": to_json(snapshot.truth),
            "path": self._take_path(),
            "asked": to_json(record.asked),
            "sent": to_json(record.sent),
            "measured": to_json(self._speeds.measure(snapshot.samples)) if self._speeds else None,
            "devices": dict(self._list_devices(snapshot)),
            "logged": {
                name: {"value": to_json(value), "unit": unit} for name, (value, unit) in snapshot.logged.items()
            },
            "interventions": list(causes),
            "is_hand_driven": bool(self._run.operator and self._run.operator.is_driving),
            "pace": describe_pace(self._run.pace) if self._run.pace else None,
            "overruns": self._run.count_overruns(),
            "faults": [str(fault) for fault in self._run.faults if fault.is_active(record.time)],
        }

    def list_pictures(self, snapshot: Snapshot) -> Iterator[tuple[str, Image]]:
        """Yield the name and the newest picture of each display and each camera."""
        for name, shown in (*snapshot.commands.items(), *snapshot.samples.items()):
            image = shown.image if isinstance(shown, Frame) else shown
            if is_picture(image):
                yield name, image

    def _list_devices(self, snapshot: Snapshot) -> Iterator[tuple[str, dict[str, Any]]]:
        for sensor in self._sensors:
            if (sample := snapshot.samples.get(sensor.name)) is not None:
                yield sensor.name, describe_sample(sensor, sample, snapshot.record.time)
        for actuator in self._actuators:
            if (command := snapshot.commands.get(actuator.name)) is not None:
                values = {} if isinstance(command, np.ndarray) else {"command": to_json(command)}
                yield actuator.name, {"values": values, "text": actuator.format_state()}
        if (sent := snapshot.record.sent) and (drive := self._run.description.drive):
            for motor in self._run.robot.motors.values():
                velocities = list_velocities(motor.name, drive.left_motors, drive.right_motors, sent)
                if isinstance(motor, AppMotor) and velocities:
                    velocity = sum(velocities) / len(velocities)
                    yield motor.name, {"values": {"command": to_json(velocity)}, "text": f"{velocity:.2f} rad/s"}


def describe_pace(pace: PaceControl) -> dict[str, Any]:
    """Return the speed, None for an unlimited one, and whether the run is paused."""
    return {"speed": to_json(pace.speed), "is_paused": pace.is_paused}


def list_velocities(motor: str, left: Sequence[str], right: Sequence[str], sent: Wheels) -> list[float]:
    """Return the commands of the wheels that a motor turns, in rad/s."""
    return [velocity for names, velocity in zip((left, right), sent, strict=True) if motor in names]


def describe_sample(sensor: Sensor[Any], sample: Any, now: float) -> dict[str, Any]:
    """Return the values of a sample, its text, its age in seconds, and its rays if it has rays.

    If the sensor's kind raises, the text is the error.

    now: the robot's time in seconds.
    """
    age = {"age": to_json(round(max(0.0, now - sample.time), 3))}
    try:
        return _describe_values(sensor, sample) | age
    except Exception as error:  # noqa: BLE001  the kind may be of another package
        return {"values": {}, "text": describe_exception(error, __file__), **age}


def _describe_values(sensor: Sensor[Any], sample: Any) -> dict[str, Any]:
    sample_type: Any = type(sample)
    fields = {value.field: getattr(sample, value.field) for value in list_values(sample_type)}
    described: dict[str, Any] = {
        "values": {
            name: to_json(value)
            for name, value in fields.items()
            if not isinstance(value, (tuple, list)) or len(value) <= MAX_NUMBERS
        },
        "text": sensor.format_sample(sample),
    }
    if sensor.has_rays:
        start, end, distances = sensor.list_rays(sample)
        step = -(-len(distances) // MAX_RAYS)
        described["rays"] = to_json({"start": start, "end": end, "distances": distances[::step]})
        described["mount"] = to_json(sensor.mount)
    return described


class WheelSpeeds:
    """Measures the velocities of the wheels from the samples of their encoders.

    left, right: the names of the encoders of each side.

    >>> from robotcore.kinds.encoder import Angle
    >>> speeds = WheelSpeeds(["left_encoder"], ["right_encoder"])
    >>> for tick in range(3):
    ...     sample = Angle(tick * 0.2, tick * 0.1, tick)
    ...     measured = speeds.measure({"left_encoder": sample, "right_encoder": sample})
    >>> measured
    Wheels(left=2, right=2)
    """

    def __init__(self, left: Sequence[str], right: Sequence[str]) -> None:
        self._sides = [side for side in (left, right) if side]
        self._history: deque[tuple[float, list[float]]] = deque(maxlen=32)
        self._last: Wheels | None = None

    def measure(self, samples: Mapping[str, Any]) -> Wheels | None:
        """Return the velocities in rad/s; None without encoders, and before the first two samples."""
        if len(self._sides) < 2 or any(name not in samples for side in self._sides for name in side):
            return None
        time = samples[self._sides[0][0]].time
        angles = [sum(samples[name].angle for name in side) / len(side) for side in self._sides]
        if self._history and time <= self._history[-1][0]:
            return self._last
        self._history.append((time, angles))
        while len(self._history) > 2 and time - self._history[1][0] >= SPEED_WINDOW_S - 1e-6:
            self._history.popleft()
        since, before = self._history[0]
        if since < time:
            left, right = ((now - then) / (time - since) for now, then in zip(angles, before, strict=True))
            self._last = Wheels(left, right)
        return self._last
