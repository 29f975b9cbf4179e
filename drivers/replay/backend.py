"""The backend `replay`, whose robot returns the samples of a recorded run to an app."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf
from pathlib import Path
from typing import Any

from pydantic import InstanceOf

from drivers.replay.devices import (
    ReplayBattery,
    ReplayCamera,
    ReplayClock,
    ReplayDisplay,
    ReplayEncoder,
    ReplayMotor,
    ReplayRangeSensor,
    SamplePlayer,
)
from robotcore.description import (
    BatteryDescription,
    CameraDescription,
    DisplayDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    RobotDescription,
    StrictModel,
)
from robotcore.errors import UnmetNeedError, UsageError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.devices import Device
from robotcore.hal.robot import Robot
from robotcore.recording import Recording, read
from robotcore.runtime.plan import RunRequest


class ReplayOptions(StrictModel):
    """The options of the backend: either ``file``, a recording's path, or ``recording``, which a program has read.

    ``is_held``: whether the safety rules of the recorded run stay in force, to verify its recorded decisions.
    """

    file: Path | None = None
    recording: InstanceOf[Recording] | None = None
    is_held: bool = False


class ReplayBackend(Backend):
    """Opens the robot of a recording. Its sensors return the recorded samples, and its motors ignore commands.

    The description of the robot is that of the recording, with relaxed safety rules; see `_relax_rules`. The backend
    does not show what happens if the app drives differently, because the samples are those of the recorded path.
    """

    name = "replay"
    summary = "replays the sensors of a recorded run to an app: --option file=RUN.mcap"
    modules = ("mcap",)

    def __init__(self) -> None:
        self._read: Recording | None = None

    @property
    def remedy(self) -> str:
        return "pip install 'robotcore[record]'"

    def load_robot(self, robot: str, options: Mapping[str, Any]) -> RobotDescription:
        """Return the description of the recorded robot; raises UsageError if the user names another robot."""
        recording = self._recording(options)
        recorded = recording.metadata
        if robot not in (RunRequest.robot, recorded.request.robot, recorded.description.name):
            raise UsageError(
                f"--robot {robot}: a replay has the robot of its recording, {recorded.description.name!r}. "
                "Leave --robot out",
                kind="replay-robot",
                robot=robot,
                recorded=recorded.description.name,
            )
        return recorded.description if options.get("is_held") else _relax_rules(recording)

    def batteries(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        batteries = {battery.name for battery in robot.all_of(BatteryDescription)}
        return frozenset(batteries.intersection(self._recording(options).metadata.devices) if batteries else ())

    def open(self, setup: Setup) -> Robot:
        setup.options_as(ReplayOptions)
        recording = self._recording(setup.options)
        _require_rate(setup, recording)
        _require_recorded(setup, recording)
        clock = ReplayClock([tick.time for tick in recording.ticks])
        return Robot(setup.robot.name, clock, _build_devices(setup, recording, clock))

    def _recording(self, options: Mapping[str, Any]) -> Recording:
        """Return the recording that the options name. Its file is read only once."""
        if isinstance(given := options.get("recording"), Recording):
            return given
        if "file" not in options:
            raise UsageError(
                "the backend 'replay' needs a recording. Name its file: --option file=RUN.mcap", kind="no-recording"
            )
        self._read = self._read or read(Path(options["file"]))
        return self._read


def _relax_rules(recording: Recording) -> RobotDescription:
    """Return the recorded robot, with the limits of two safety rules longer than the recording, so they never act.

    ``follow_s`` cannot be kept, because the recorded wheels do not follow the commands of the replayed app.
    ``max_age_s`` cannot be kept, because a sample that the recorded app did not read is not in the recording.
    """
    description, ticks = recording.metadata.description, recording.ticks
    lasts = ticks[-1].time - ticks[0].time if ticks else 0.0
    waits = {name: lasts + getattr(description.safety, name) for name in ("max_age_s", "follow_s")}
    return description.model_copy(update={"safety": description.safety.model_copy(update=waits)})


def _build_devices(setup: Setup, recording: Recording, clock: ReplayClock) -> Iterator[Device]:
    for device in setup.chosen_devices:
        name = device.name
        if isinstance(device, MotorDescription):
            yield ReplayMotor(name, device.max_velocity_rad_s)
        elif isinstance(device, RangeSensorDescription):
            yield ReplayRangeSensor(device, SamplePlayer(name, recording, clock))
        elif isinstance(device, CameraDescription):
            yield ReplayCamera(device, SamplePlayer(name, recording, clock))
        elif isinstance(device, DisplayDescription):
            yield ReplayDisplay(name, recording, clock)
        elif isinstance(device, EncoderDescription):
            yield ReplayEncoder(name, SamplePlayer(name, recording, clock))
        else:
            battery: BatteryDescription = device  # the type checker reports a new kind of device here
            yield ReplayBattery(battery.name, SamplePlayer(name, recording, clock))
    yield from _build_lone_motors(setup, recording)


def _build_lone_motors(setup: Setup, recording: Recording) -> Iterator[Device]:
    """Yield the motors that the recorded run commanded and that the app has not chosen."""
    chosen = {device.name for device in setup.chosen_devices}
    limits = {device.name: device.max_velocity_rad_s for device in setup.robot.all_of(MotorDescription)}
    for name in sorted({ask.device for tick in recording.ticks for ask in tick.motor_asks} - chosen):
        yield ReplayMotor(name, limits.get(name, inf))


def _require_rate(setup: Setup, recording: Recording) -> None:
    recorded = recording.metadata.request.rate_hz
    if setup.rate_hz != recorded:
        raise UsageError(
            f"--rate {setup.rate_hz:g}: a run recorded at {recorded:g} Hz can only be replayed at that rate. "
            f"Take --rate {recorded:g}",
            kind="replay-rate",
            rate_hz=setup.rate_hz,
            recorded_hz=recorded,
        )


def _require_recorded(setup: Setup, recording: Recording) -> None:
    """Raise UnmetNeedError if the recorded run had not opened a needed sensor."""
    sensors = {device.name for device in setup.chosen_devices if device.kind not in ("motor", "display")}
    opened = recording.metadata.devices
    if missing := sorted(sensors.difference(opened)):
        names, app = ", ".join(missing), recording.metadata.request.app
        raise UnmetNeedError(
            f"the recording has no samples of {names}: its run, of {app!r}, had opened {', '.join(opened)}. "
            f"Record a run of an app that needs {names} too",
            kind="not-recorded",
            devices=missing,
            opened=list(opened),
        )
