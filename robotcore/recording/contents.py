"""What a recording holds."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from robotcore.recording.ended import result_of
from robotcore.recording.events import Read, Tick
from robotcore.recording.recording import Recording

_SHORTEST_S = 1e-6
"""Of a run with a rate."""


@dataclass(frozen=True)
class DeviceContents:
    """What there is of one device: ``samples`` that differ, ``reads`` of them, ``errors`` in place of them.

    ``rate_hz`` is how many samples there were a second; None where the run took no time.
    """

    name: str
    kind: str
    samples: int
    reads: int
    errors: int
    rate_hz: float | None


def duration_of(recording: Recording) -> float:
    """Return the time from the first tick to the last, in seconds."""
    ticks = recording.ticks
    return ticks[-1].time - ticks[0].time if ticks else 0.0


def rate_of(recording: Recording) -> float | None:
    """Return how many ticks a second there were; None where no time passed."""
    duration = duration_of(recording)
    return (len(recording.ticks) - 1) / duration if duration > _SHORTEST_S else None


def interventions_of(recording: Recording) -> dict[str, int]:
    """Return how often each rule of the safety stage changed a command."""
    return dict(Counter(each.cause for tick in recording.ticks for each in tick.interventions))


def devices_of(recording: Recording) -> Iterator[DeviceContents]:
    """Yield what there is of each device that was open, in the order of the robot's description."""
    duration, opened = duration_of(recording), set(recording.metadata.devices)
    sequences: defaultdict[str, set[int | None]] = defaultdict(set)
    reads, shown, errors = Counter[str](), Counter[str](), Counter[str]()
    for tick in recording.ticks:
        for each in tick.shown:
            (errors if each.error else shown)[each.device] += 1
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
            yield DeviceContents(name, device.kind, samples, reads[name], errors[name], rate)


def contents_of(recording: Recording) -> dict[str, Any]:
    """Return all of it for JSON; null is what nobody knows."""
    about, result = recording.metadata, result_of(recording)
    return {
        "app": result.app,
        "backend": result.backend,
        "robot": result.robot,
        "world": result.world,
        "seed": result.seed,
        "settings": {name: str(value) for name, value in about.request.settings.items()},
        "started": about.started,
        "platform": dict(about.platform),
        "duration_s": duration_of(recording),
        "ticks": len(recording.ticks),
        "rate_hz": rate_of(recording),
        "overruns": result.overruns,
        "devices": [asdict(device) for device in devices_of(recording)],
        "faults": result.faults,
        "dropped_pictures": result.dropped_pictures,
        "interventions": interventions_of(recording),
        "milestones": result.milestones,
        "batteries": result.batteries,
        "outcome": recording.result.outcome.value if recording.result else None,
        "reason": result.reason,
        "trace_sha256": result.trace_sha256,
        "whole": not recording.is_cut,
        "damaged": recording.is_damaged,
        "replayable": recording.is_replayable,
        "why_not": recording.why_not or None,
    }


def last_reads(tick: Tick) -> dict[str, Read]:
    """Return the last sample that each device gave in a tick, by device."""
    return {read.device: read for read in tick.reads if not read.error}
