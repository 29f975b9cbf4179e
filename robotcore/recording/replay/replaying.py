"""A recorded run, decided once more by the same app."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from robotcore.errors import Interrupted, RecordingError
from robotcore.recording import Recording
from robotcore.recording.replay.ending import hold_end
from robotcore.recording.replay.gate import has_changed, require_recorded_app
from robotcore.recording.replay.likeness import ACROSS_PLATFORMS, Likeness
from robotcore.recording.replay.platforms import differences
from robotcore.recording.replay.replayer import Replayer
from robotcore.recording.replay.verdict import Replayed
from robotcore.runtime.outcome import RunResult
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.session import Observer, run

BACKEND = "replay"


def replay(
    recording: Recording, file: Path | str = "", observers: Sequence[Observer] = (), *, app: str | None = None
) -> Replayed:
    """Run the recorded app on what it was given then, and hold each tick to the recorded one.

    ``file`` is what messages call the recording. ``app`` names the app's file, which then may have changed; without it
    a file is run only if it holds the recorded text. Raises RecordingError if the recording does not hold all that
    steered its run, and the app's own error if the app cannot be run at all.
    """
    require_ticks(recording, file)
    if not recording.is_replayable:
        raise RecordingError(
            file or "the recording",
            f"it cannot be replayed: {recording.why_not}",
            "robotcore replay FILE --app APP runs an app on what it has",
        )
    if app is None:
        require_recorded_app(recording, file)
    platform = differences(recording.metadata.platform, BACKEND)
    likeness = Likeness(ACROSS_PLATFORMS if platform else 0.0)
    replayer = Replayer(recording, likeness)
    request = request_for(recording, is_held=True)
    request = replace(request, app=app or request.app)
    result = run(request, [replayer, *observers], [replayer])
    if result.error and not isinstance(result.error, Interrupted) and not result.ticks:
        raise result.error
    if not isinstance(result.error, Interrupted):
        hold_end(replayer.script, result)
    result = replace(result, backend=recording.metadata.request.backend)
    return _build_replayed(replayer, likeness, result, platform, has_changed=has_changed(recording, request.app))


def require_ticks(recording: Recording, file: Path | str) -> None:
    """Raise RecordingError if a recording has no tick to be replayed."""
    if not recording.ticks:
        raise RecordingError(file or "the recording", "it ends before the first tick", "Record a run that begins")


def request_for(recording: Recording, *, is_held: bool = False) -> RunRequest:
    """Return the request that runs the recorded app, with its recorded settings, on its recording.

    Where the app ``is_held`` to what it decided, the rules that can end its run are the recorded ones.
    """
    recorded = recording.metadata.request
    return RunRequest(
        app=recorded.app,
        backend=BACKEND,
        seed=recorded.seed,
        rate_hz=recorded.rate_hz,
        timeout_s=recorded.timeout_s,
        settings=recorded.settings,
        options={"recording": recording, "is_held": is_held},
    )


def _build_replayed(
    replayer: Replayer, likeness: Likeness, result: RunResult, platform: Sequence[str], *, has_changed: bool | None
) -> Replayed:
    script = replayer.script
    return Replayed(
        recording=script.recording,
        result=result,
        ticks=script.compared,
        deviation=script.deviation,
        is_exact=likeness.is_exact,
        largest_difference=likeness.largest,
        trace_sha256=script.trace.sha256,
        platform=tuple(platform),
        has_app_changed=has_changed,
    )
