"""A recorded run, decided once more: by the same app, which is held to each tick, or by another one."""

from robotcore.recording.replay.deviation import Deviation
from robotcore.recording.replay.gate import is_recorded_file
from robotcore.recording.replay.rehearsal import Rehearsed, rehearse
from robotcore.recording.replay.replaying import replay
from robotcore.recording.replay.verdict import Replayed

__all__ = ["Deviation", "Rehearsed", "Replayed", "is_recorded_file", "rehearse", "replay"]
