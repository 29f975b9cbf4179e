"""Replay a recording: verify the decisions of its app, or evaluate another app on its samples."""

from robotcore.recording.replay.app_permission import is_recorded_app
from robotcore.recording.replay.differences import Deviation
from robotcore.recording.replay.evaluation import Evaluation, evaluate
from robotcore.recording.replay.replay_recorder import ReplayRecorder
from robotcore.recording.replay.verification import ReplayResult, replay

__all__ = ["Deviation", "Evaluation", "ReplayRecorder", "ReplayResult", "evaluate", "is_recorded_app", "replay"]
