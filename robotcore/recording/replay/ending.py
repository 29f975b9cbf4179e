"""The end of a replay, held to the end of its recording."""

from __future__ import annotations

import re
from contextlib import suppress

from robotcore.errors import DeviationError, RecordingEndedError
from robotcore.recording import Recording
from robotcore.recording.ended import why_no_end
from robotcore.recording.replay.cues import Cues
from robotcore.recording.replay.script import Script
from robotcore.runtime.outcome import Outcome, RunResult

_GOES_ON = "the app goes on"


def hold_end(script: Script, result: RunResult) -> None:
    """Let the script deviate where the replay ended otherwise than its recording."""
    with suppress(DeviationError, RecordingEndedError):
        _hold(script, result)


def ended_from_outside(recording: Recording) -> str:
    """Say what ended the recording and cannot be repeated: a signal, a dead simulator, the file; empty if nothing."""
    result, last = recording.result, recording.ticks[-1]
    if result is None:
        return why_no_end(recording)
    is_of_the_last_tick = last.error is not None and not Cues(last).is_cut_short
    is_of_the_app = result.outcome in (Outcome.SUCCESS, Outcome.FAILURE, Outcome.TIMEOUT)
    return "" if is_of_the_last_tick or is_of_the_app else result.reason


def _hold(script: Script, result: RunResult) -> None:
    if script.deviation or script.is_at_end:
        return
    recording = script.recording
    left = len(recording.ticks) - script.compared
    if isinstance(result.error, RecordingEndedError):
        if not ended_from_outside(recording):
            script.deviate("the end", _recorded(recording), _GOES_ON)
    elif left and not script.cues.is_cut_short:
        script.deviate("the end", _GOES_ON, _told(result.outcome, result.reason))
    elif not ended_from_outside(recording) and _comparable(result) != _recorded(recording):
        script.deviate("the end", _recorded(recording), _comparable(result))


def _comparable(result: RunResult) -> str:
    return _told(result.outcome, str(result.error) if result.error else result.reason)


def _recorded(recording: Recording) -> str:
    result, last = recording.result, recording.ticks[-1]
    assert result, "it did not end from outside"
    return _told(result.outcome, last.error.message if last.error else result.reason)


def _told(outcome: Outcome, reason: str) -> str:
    """Return an outcome and its reason, without what may differ: addresses of objects, and the app's line."""
    same = re.sub(r", at \S+\.py:\d+", "", re.sub(r"\b0x[0-9a-fA-F]+\b", "0x…", reason))
    return f"{outcome.value}: {same}" if same else outcome.value
