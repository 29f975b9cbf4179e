"""How a recorded run ended, as far as its file tells."""

from __future__ import annotations

from robotcore.outcome import Outcome, RunResult
from robotcore.recording.recording import Recording


def result_of(recording: Recording) -> RunResult:
    """Return the recorded result; of a file that was cut, what is known of it."""
    if recording.result:
        return recording.result
    request, world, ticks = recording.metadata.request, recording.metadata.world, recording.ticks
    return RunResult(
        app=request.app,
        backend=request.backend,
        robot=recording.metadata.description.name,
        world=world.name if world else None,
        seed=request.seed,
        outcome=Outcome.ERROR,
        exit_status=1,
        reason="the file was cut before the run ended",
        sim_time_s=ticks[-1].time if ticks else 0.0,
        ticks=len(ticks),
    )
