"""Runs whose app uses up the threads or the memory that the system gives their process."""

from __future__ import annotations

import json

import pytest

from tests.robotcore.safety.guardian.doubles import MOTORS, UNGUARDED, Running, Start
from tests.robotcore.safety.guardian.recorder import notes

pytestmark = pytest.mark.linux("the limit is one of Linux's address space")

LATE_S = 0.5
"""The longest time to a stop. The lease is 0.125 s, and the watchdog would act after 3 s."""

HANGS, RAISES, DRIVES_ON, ASKS_FOR_NAN = (4, "stopped"), (5, "error"), (0, "success"), (4, "stopped")
"""The exit status and the outcome of each app."""


@pytest.mark.slow
@pytest.mark.parametrize("manner", ["good", UNGUARDED])
@pytest.mark.parametrize(
    "app, ending",
    [
        ("leaks_threads_and_hangs", HANGS),
        ("leaks_threads_and_raises", RAISES),
        ("leaks_threads_and_drives_on", DRIVES_ON),
        ("leaks_threads_and_asks_for_nan", ASKS_FOR_NAN),
        ("leaks_memory_and_hangs", HANGS),
        ("leaks_memory_and_raises", RAISES),
    ],
)
def test_a_run_without_threads_or_memory_stops_every_motor_and_ends_as_usual(
    start: Start, app: str, ending: tuple[int, str], manner: str
) -> None:
    running = start(app, manner)
    out, err = running.end()
    result = json.loads(out or f'"{err}"')
    assert (result["exit_status"], result["outcome"]) == ending
    assert running.process.returncode == ending[0]
    assert _last_commands(running) == {"stand"}
    assert _seconds_to_stop(running) < LATE_S


@pytest.mark.slow
def test_memory_that_runs_out_in_the_framework_ends_the_run_with_an_error(start: Start) -> None:
    running = start("leaks_memory_and_drives_on", UNGUARDED)
    out, err = running.end()
    assert running.process.returncode in {3, 5}, err
    assert '"outcome": "error"' in out
    assert _last_commands(running) == {"stand"}


def _last_commands(running: Running) -> set[str]:
    """Return the last command of each wheel's motor."""
    last: dict[str, str] = {}
    for action in running.actions:
        command, _, motor = action.partition(" ")
        if command in {"turn", "stand"}:
            last[motor] = command
    return {last[motor] for motor in MOTORS[:2]}


def _seconds_to_stop(running: Running) -> float:
    """Return the seconds from the last command that turned a wheel to the stop of the last wheel."""
    recorded = notes(running.diary)
    last_turn = max(index for index, note in enumerate(recorded) if note.action.startswith("turn"))
    stops = [next(n.time for n in recorded[last_turn:] if n.action == f"stand {motor}") for motor in MOTORS[:2]]
    return max(stops) - recorded[last_turn].time
