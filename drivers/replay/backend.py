"""The backend ``replay``: a robot whose sensors return the samples of a recorded run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf
from pathlib import Path
from typing import Any

from pydantic import InstanceOf

from drivers.replay.devices import ReplayClock, ReplayMotor, ReplayReader, ReplaySender
from robotcore.description import RobotDescription, StrictModel
from robotcore.errors import UnmetNeedError, UsageError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.device import Device, Sensor
from robotcore.hal.kind import build_actuator, build_sensor, list_monitored, load_kind
from robotcore.hal.robot import Robot
from robotcore.kinds.motor import MotorDescription
from robotcore.recording import Recording, read
from robotcore.runtime.plan import RunRequest


class ReplayOptions(StrictModel):
    """The options of the backend. Either ``file`` or ``recording`` must be set."""

    file: Path | None = None
    """The file of the recording."""
    recording: InstanceOf[Recording] | None = None
    """The recording, if a program has read it already."""
    keeps_safety_rules: bool = False
    """Whether the robot has the safety rules of the recorded run, to verify their recorded interventions.

    Otherwise ``follow_s`` and ``max_age_s`` are longer than the recording, so that a changed app is not stopped.
    """


class ReplayBackend(Backend):
    """Opens the robot of a recording. Its sensors return the recorded samples, and its motors ignore commands.

    The samples do not depend on the app's commands: an app that drives another path still reads those of the recorded
    path.
    """

    name = "replay"
    summary = "returns the sensor samples of a recorded run: --option file=RUN.mcap"
    modules = ("mcap",)

    def __init__(self) -> None:
        self._read: Recording | None = None

    @property
    def remedy(self) -> str:
        return "pip install 'robotcore[record]'"

    def load_robot(self, robot: str, options: Mapping[str, Any]) -> RobotDescription:
        """Return the description of the recorded robot. Raises UsageError if the user names another robot."""
        recording = self._recording(options)
        recorded = recording.metadata
        if robot not in (RunRequest.robot, recorded.request.robot, recorded.description.name):
            raise UsageError(
                f"--robot {robot}: a replay uses the robot of its recording, {recorded.description.name!r}. "
                "Leave --robot out",
                kind="replay-robot",
                robot=robot,
                recorded=recorded.description.name,
            )
        return recorded.description if options.get("keeps_safety_rules") else _relax_rules(recording)

    def openable(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        names = frozenset(device.name for device in robot.devices)
        if not (monitored := list_monitored(robot)):
            return names
        return names - (monitored - set(self._recording(options).metadata.devices))

    def open(self, setup: Setup) -> Robot:
        setup.options_as(ReplayOptions)
        recording = self._recording(setup.options)
        _require_rate(setup, recording)
        _require_recorded(setup, recording)
        clock = ReplayClock([tick.time for tick in recording.ticks])
        return Robot(setup.robot.name, clock, _build_devices(setup, recording, clock))

    def _recording(self, options: Mapping[str, Any]) -> Recording:
        if isinstance(given := options.get("recording"), Recording):
            return given
        if "file" not in options:
            raise UsageError(
                "the backend 'replay' needs a recording. Name its file: --option file=RUN.mcap", kind="no-recording"
            )
        self._read = self._read or read(Path(options["file"]))
        return self._read


def _relax_rules(recording: Recording) -> RobotDescription:
    """Return the recorded robot with two time limits of safety rules longer than the recording, so they never expire.

    ``follow_s`` would expire, because the recorded wheels do not follow the commands of another app.
    ``max_age_s`` would expire, because a sample that the recorded app did not read is not in the recording.
    """
    description, ticks = recording.metadata.description, recording.ticks
    lasts = ticks[-1].time - ticks[0].time if ticks else 0.0
    waits = {name: lasts + getattr(description.safety, name) for name in ("max_age_s", "follow_s")}
    return description.model_copy(update={"safety": description.safety.model_copy(update=waits)})


def _build_devices(setup: Setup, recording: Recording, clock: ReplayClock) -> Iterator[Device]:
    for device in setup.chosen_devices:
        recorded = recording, clock, device.name
        kind = load_kind(device.kind).device
        if isinstance(device, MotorDescription):
            yield ReplayMotor(device.name, device.max_velocity_rad_s)
        elif issubclass(kind, Sensor):
            sensor = build_sensor(device, ReplayReader(*recorded))
            sensor.is_compensated = True
            yield sensor
        else:
            actuator = build_actuator(device, ReplaySender(*recorded))
            vars(actuator)["stop"] = lambda: None  # stops are not recorded
            yield actuator
    # A driver may have opened a motor that is not in the robot's description, and the app may have commanded it.
    chosen = {device.name for device in setup.chosen_devices}
    limits = {device.name: device.max_velocity_rad_s for device in setup.robot.all_of(MotorDescription)}
    for name in sorted({ask.device for tick in recording.ticks for ask in tick.motor_asks} - chosen):
        yield ReplayMotor(name, limits.get(name, inf))


def _require_rate(setup: Setup, recording: Recording) -> None:
    recorded = recording.metadata.request.rate_hz
    if setup.rate_hz != recorded:
        raise UsageError(
            f"--rate {setup.rate_hz:g}: a run recorded at {recorded:g} Hz can be replayed only at this rate. "
            f"Use --rate {recorded:g}",
            kind="replay-rate",
            rate_hz=setup.rate_hz,
            recorded_hz=recorded,
        )


def _require_recorded(setup: Setup, recording: Recording) -> None:
    sensors = {each.name for each in setup.chosen_devices if issubclass(load_kind(each.kind).device, Sensor)}
    opened = recording.metadata.devices
    if missing := sorted(sensors.difference(opened)):
        names, app = ", ".join(missing), recording.metadata.request.app_reference
        raise UnmetNeedError(
            f"the recording has no samples of {names}. The recorded app {app!r} opened only {', '.join(opened)}: "
            f"record a run of an app that needs {names} too",
            kind="not-recorded",
            devices=missing,
            opened=list(opened),
        )
