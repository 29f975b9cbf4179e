"""A recorded run in one picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from robotcore.description import Floor, WorldDescription
from robotcore.hal.devices import Frame, Image
from robotcore.recording import Recording, SampleKey, Tick
from robotcore.recording.ended import result_of
from robotcore.recording.path import odometry_path, true_path
from robotcore.runtime.outcome import RunResult
from robotcore.view.sheet import Story
from robotcore.view.track import Footstep, Track

_ROOM_M = 0.5
"""Around a path in an unknown place."""

_LARGEST_M = 100.0
"""No floor is described larger; a path that leads beyond it is drawn all the same."""


def story_of(
    recording: Recording,
    states: Sequence[str] | None = None,
    result: RunResult | None = None,
    *,
    is_rehearsal: bool = False,
) -> Story:
    """Return what a picture tells of a recording: the true path where a simulator told it, else the odometry's.

    ``states`` and ``result`` are those of a replay, which may end before its recording, or of a rehearsal.
    """
    about, path = recording.metadata, true_path(recording) or odometry_path(recording)
    track = Track()
    told = [tick.state for tick in recording.ticks] if states is None else states
    ticks = recording.ticks[: len(told)]
    for tick, state in zip(ticks, told, strict=False):
        if tick.number in path:
            track.steps.append(Footstep(tick.time, state, path[tick.number]))
    recorded = result_of(recording)
    ended = replace(result, world=recorded.world) if result else recorded
    return Story(
        *(about.description, world_of(recording, track), track, last_seen(recording, ticks), ended),
        recorded=recorded if is_rehearsal else None,
    )


def last_seen(recording: Recording, ticks: Sequence[Tick]) -> Image | None:
    """Return the picture that was shown last in some ticks, else the one that was read last."""
    shown = (each.key for tick in reversed(ticks) for each in reversed(tick.shown))
    read = (each.key for tick in reversed(ticks) for each in reversed(tick.reads))
    for keys in (shown, read):
        if frame := next(filter(None, (_frame(recording, key) for key in keys)), None):
            return frame.image
    return None


def _frame(recording: Recording, key: SampleKey | None) -> Frame | None:
    sample = recording.samples.get(key) if key else None
    return sample if isinstance(sample, Frame) else None


def world_of(recording: Recording, track: Track) -> WorldDescription:
    """Return the recorded world; where none was described, a floor that the track fits on."""
    if world := recording.metadata.world:
        return world
    reach = max((max(abs(step.pose.x), abs(step.pose.y)) for step in track.steps), default=0.0)
    side = min(2 * (reach + _ROOM_M), _LARGEST_M)
    return WorldDescription(name="floor", floor=Floor(length_m=side, width_m=side))
