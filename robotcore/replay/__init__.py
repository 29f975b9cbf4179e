"""A recorded run, decided once more: by the same app, which is held to each tick, or by another one."""

from robotcore.replay.deviation import Deviation
from robotcore.replay.gate import is_recorded_file
from robotcore.replay.rehearsal import Rehearsed, rehearse
from robotcore.replay.replaying import replay
from robotcore.replay.verdict import Replayed

__all__ = ["Deviation", "Rehearsed", "Replayed", "is_recorded_file", "rehearse", "replay"]
