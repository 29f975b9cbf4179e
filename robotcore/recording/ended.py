"""How a recorded run ended, as far as its file tells."""

from __future__ import annotations

from collections.abc import Container

from robotcore.description import BatteryDescription
from robotcore.hal.devices import Voltage
from robotcore.recording.events import Tick
from robotcore.recording.recording import Recording
from robotcore.runtime.apps import app_name
from robotcore.runtime.outcome import Outcome, RunResult
from robotcore.runtime.trace import TickRecord, Trace


def result_of(recording: Recording) -> RunResult:
    """Return the recorded result; of a file that ends before the run did, what is known of it."""
    if recording.result:
        return recording.result
    trace = _trace_of(recording)
    request, world, ticks = recording.metadata.request, recording.metadata.world, recording.ticks
    return RunResult(
        app=app_name(request.app),
        backend=request.backend,
        robot=recording.metadata.description.name,
        world=world.name if world else None,
        seed=request.seed,
        outcome=Outcome.ERROR,
        exit_status=1,
        reason=why_no_end(recording),
        sim_time_s=ticks[-1].time if ticks else 0.0,
        ticks=len(ticks),
        milestones=trace.milestones,
        interventions=trace.interventions,
        faults=list(request.faults),
        notes=list(trace.warnings),
        batteries=trace.batteries,
    )


def why_no_end(recording: Recording) -> str:
    """Say why a recording has no result; empty where it has one."""
    if recording.result:
        return ""
    if recording.ended_early:
        return recording.ended_early
    if not recording.is_damaged:
        return "the file was cut before the run ended"
    at = recording.ticks[-1].time if recording.ticks else 0.0
    return f"the file is damaged at {at:.1f} s: what comes after is not read ({recording.damage})"


def _trace_of(recording: Recording) -> Trace:
    trace = Trace(tuple(recording.metadata.milestones))
    batteries = {battery.name for battery in recording.metadata.description.all_of(BatteryDescription)}
    for tick in recording.ticks:
        decided = tick.asked, tick.sent, tick.interventions
        trace.add(
            TickRecord(
                *(tick.number, tick.time, tick.state, *decided),
                voltages=_voltages_in(tick, recording, batteries),
                warnings=tick.warnings,
            )
        )
    return trace


def _voltages_in(tick: Tick, recording: Recording, batteries: Container[str]) -> dict[str, float]:
    """Return what was read of batteries in a tick, in volts; no picture is read for it."""
    keys = [read.key for read in tick.reads if read.key and read.device in batteries]
    samples = {key.device: recording.samples.get(key) for key in keys}
    return {device: sample.voltage for device, sample in samples.items() if isinstance(sample, Voltage)}
