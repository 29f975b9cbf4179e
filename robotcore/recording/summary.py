"""Summarise a recording: its result, the robot's path, and the reads of each device."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Container, Iterable, Iterator
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

from robotcore.geometry import Pose
from robotcore.hal.kind import list_monitored
from robotcore.recording.events import Tick
from robotcore.recording.logged_summary import LoggedSeries, LoggedSummary
from robotcore.recording.recording import Recording
from robotcore.runtime.apps import app_name
from robotcore.runtime.intervention_timer import InterventionTimer
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.sensor_monitor import find_number
from robotcore.runtime.trace import MonitoredValue, TickRecord, Trace


def build_result(recording: Recording) -> RunResult:
    """Return the result of a recorded run. If the file has none, compute it from the ticks."""
    if recording.result:
        return recording.result
    trace, timer = Trace(tuple(recording.metadata.milestones)), InterventionTimer()
    for record in _list_records(recording):
        trace.add(record)
        timer.add(record)
    request, world, ticks = recording.metadata.request, recording.metadata.world, recording.ticks
    return RunResult(
        app=app_name(request.app_reference),
        backend=request.backend,
        robot=recording.metadata.description.name,
        world=world.name if world else None,
        seed=request.seed,
        outcome=Outcome.ERROR,
        exit_status=1,
        reason=explain_missing_end(recording),
        sim_time_s=ticks[-1].time if ticks else 0.0,
        ticks=len(ticks),
        milestones=trace.milestones,
        interventions=trace.interventions,
        intervention_s=timer.measure(),
        faults=list(request.faults),
        notes=list(trace.warnings),
        batteries=trace.voltages,
    )


def explain_missing_end(recording: Recording) -> str:
    """Return why a recording has no result; an empty text if it has one."""
    if recording.result:
        return ""
    if recording.ended_early:
        return recording.ended_early
    if not recording.is_damaged:
        return "the file was cut before the run ended"
    at = recording.ticks[-1].time if recording.ticks else 0.0
    return f"the file is damaged, and was read until {at:.1f} s only ({recording.damage})"


def _list_records(recording: Recording) -> Iterator[TickRecord]:
    monitored = list_monitored(recording.metadata.description)
    for tick in recording.ticks:
        decided = tick.asked, tick.sent, tick.interventions
        yield TickRecord(
            *(tick.number, tick.time, tick.state, *decided),
            monitored=_read_values(tick, recording, monitored),
            warnings=tick.warnings,
        )


def _read_values(tick: Tick, recording: Recording, monitored: Container[str]) -> dict[str, MonitoredValue]:
    keys = [read.key for read in tick.reads if read.key and read.device in monitored]
    samples = {key.device: recording.samples.get(key) for key in keys}
    values = {device: find_number(sample) for device, sample in samples.items() if sample}
    return {device: value for device, value in values.items() if value and math.isfinite(value.value)}


PosePath = dict[int, Pose]
"""Poses by tick number, in world coordinates; without a world relative to the start."""


_MAX_M = 1e6
"""The largest valid coordinate, in metres. An invalid encoder value can cause a larger one."""


def build_odometry_path(recording: Recording) -> PosePath:
    """Return the path by odometry; empty if the robot has no drive."""
    world = recording.metadata.world
    start = world.start.pose if world else Pose(0.0, 0.0, 0.0)
    return {tick.number: start.compose(tick.pose) for tick in recording.ticks if tick.pose and is_plausible(tick.pose)}


def build_true_path(recording: Recording) -> PosePath:
    """Return the true path; empty if no simulator measured it."""
    return {sample.tick: sample.pose for sample in recording.truth if is_plausible(sample.pose)}


def is_plausible(pose: Pose) -> bool:
    """Return whether a pose is finite and near enough to be drawn. An invalid encoder value can cause another one."""
    return max(abs(pose.x), abs(pose.y)) <= _MAX_M and math.isfinite(pose.heading) and not math.isnan(pose.x + pose.y)


def measure_path(path: Iterable[Pose]) -> float:
    """Return the length of a path in metres."""
    return sum(one.distance_to(other.x, other.y) for one, other in pairwise(path))


_SHORTEST_S = 1e-6
"""The minimum duration for which a rate is computed, in seconds."""


@dataclass(frozen=True)
class DeviceContents:
    """How many samples, reads, commands and errors of a device a recording has."""

    name: str
    """The name of the device."""
    kind: str
    """The kind of the device."""
    samples: int
    """The number of samples. A sample that was read several times counts once."""
    reads: int
    """The number of reads that returned a sample."""
    commands: int
    """The number of commands of the app to the device that raised no error. Commands to the drive do not count."""
    errors: int
    """The number of reads and commands that raised an error."""
    rate_hz: float | None
    """The number of samples per second; None without samples, or if the run took no time."""


def measure_duration(recording: Recording) -> float:
    """Return the time from the first tick to the last, in seconds."""
    ticks = recording.ticks
    return ticks[-1].time - ticks[0].time if ticks else 0.0


def measure_rate(recording: Recording) -> float | None:
    """Return the number of ticks per second; None if the run took no time."""
    duration = measure_duration(recording)
    return (len(recording.ticks) - 1) / duration if duration > _SHORTEST_S else None


def count_interventions(recording: Recording) -> dict[str, int]:
    """Return how many commands each rule of the safety stage changed, by the rule's name."""
    return dict(Counter(each.cause for tick in recording.ticks for each in tick.interventions))


def summarise_devices(recording: Recording) -> Iterator[DeviceContents]:
    """Count the samples, reads, commands and errors of each open device, in the order of the robot's description."""
    duration, opened = measure_duration(recording), set(recording.metadata.devices)
    sequences: defaultdict[str, set[int | None]] = defaultdict(set)
    reads, shown, commands, errors = Counter[str](), Counter[str](), Counter[str](), Counter[str]()
    for tick in recording.ticks:
        for each in tick.shown:
            (errors if each.error else shown)[each.device] += 1
        for command in tick.list_commands():
            (errors if command.error else commands)[command.device] += 1
        for read in tick.reads:
            if read.error:
                errors[read.device] += 1
            else:
                reads[read.device] += 1
                sequences[read.device].add(read.sequence)
    for device in recording.metadata.description.devices:
        if (name := device.name) in opened:
            samples = len(sequences[name]) + shown[name]
            rate = (samples - 1) / duration if samples and duration > _SHORTEST_S else None
            sent = commands[name] + shown[name]
            yield DeviceContents(name, device.kind, samples, reads[name], sent, errors[name], rate)


def summarise_recorded_log(recording: Recording) -> list[LoggedSeries]:
    """Return a summary of the values that the app logged in a recorded run, by name."""
    summary = LoggedSummary()
    for tick in recording.ticks:
        summary.add(recording.logged.get(tick.number, {}))
    return summary.series


def format_settings(recording: Recording) -> dict[str, str]:
    """Return the settings of the app that differ from their defaults, as texts by name."""
    return {name: str(value) for name, value in recording.metadata.request.settings.items()}


def summarise_contents(recording: Recording) -> dict[str, Any]:
    """Return the JSON fields of ``robotcore info``; an unknown value is None.

    The JSON keys:

    app: text; the name of the app.
    backend: text; the name of the backend.
    robot: text; the name of the robot.
    world: text or null; the name of the world.
    seed: whole number or null; the seed of the run.
    settings: object of text; the settings of the app that differ from their defaults.
    started: text; the date and time of the start.
    platform: object of text; the versions of the machine's system, of Python and of libraries.
    duration_s: number, s; the time from the first tick to the last.
    ticks: whole number; the number of ticks.
    rate_hz: number or null, Hz; the number of ticks per second.
    overruns: whole number; the number of ticks that took longer than their period.
    devices: list of objects; the open devices.
    devices[].*: robotcore.recording.summary.DeviceContents
    logged: list of objects; the values that the app logged.
    logged[].*: robotcore.recording.logged_summary.LoggedSeries.to_dict
    faults: list of text; the injected faults.
    dropped_pictures: whole number or null; the number of pictures that are missing in the recording.
    interventions: object of whole numbers; the number of commands that each rule of the safety stage changed.
    intervention_s: object of numbers, s; for each rule the time for which its changed commands lasted.
    milestones: object of numbers, s; the time of each milestone.
    batteries: object; for each battery the lowest and the last voltage in V, ``lowest_v`` and ``last_v``.
    outcome: text or null; the outcome. Null if the recording has no end.
    reason: text; why the run ended, or why the recording has no end.
    trace_sha256: text or null; the digest of the trace.
    whole: true or false; whether the file has its end.
    damaged: true or false; whether a part of the file cannot be read.
    replayable: true or false; whether ``robotcore replay`` can run the recorded app again.
    why_not: text or null; which inputs are missing for that.
    """
    about, result = recording.metadata, build_result(recording)
    return {
        "app": result.app,
        "backend": result.backend,
        "robot": result.robot,
        "world": result.world,
        "seed": result.seed,
        "settings": format_settings(recording),
        "started": about.started,
        "platform": dict(about.platform),
        "duration_s": measure_duration(recording),
        "ticks": len(recording.ticks),
        "rate_hz": measure_rate(recording),
        "overruns": result.overruns,
        "devices": [asdict(device) for device in summarise_devices(recording)],
        "logged": [series.to_dict() for series in summarise_recorded_log(recording)],
        "faults": result.faults,
        "dropped_pictures": result.dropped_pictures,
        "interventions": count_interventions(recording),
        "intervention_s": result.intervention_s,
        "milestones": result.milestones,
        "batteries": result.batteries,
        "outcome": recording.result.outcome.value if recording.result else None,
        "reason": result.reason,
        "trace_sha256": result.trace_sha256,
        "whole": not recording.is_cut,
        "damaged": recording.is_damaged,
        "replayable": recording.is_replayable,
        "why_not": recording.missing_inputs or None,
    }
