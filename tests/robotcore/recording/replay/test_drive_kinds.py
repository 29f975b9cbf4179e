"""Runs of robots whose wheels skid or steer are recorded, replayed, and replayed with another app."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotcore import RunRequest, run
from robotcore.recording.replay import replay
from robotcore.runtime.result import Outcome
from tests.robotcore.recording.replay.memory import record_run
from tests.robotcore.recording.replay.recorded_apps import Weave

APP = f"{Path(__file__).parent / 'recorded_apps.py'}:Weave"


@pytest.mark.parametrize(
    "robot, faults",
    [
        ("freenove-4wd", ()),
        ("freenove-4wd", ("drive weak=0.5",)),
        ("freenove-4wd", ("rear_left_motor dead after=0.5",)),
        ("picar", ()),
        ("picar", ("drive weak=0.5", "encoders slip=0.3")),
        ("picar", ("right_motor dead after=0.5",)),
        ("picar", ("servo lost=0.3 after=0.5",)),
    ],
)
def test_run_is_replayed_bit_equal(robot: str, faults: tuple[str, ...]) -> None:
    recording = record_run(APP, robot=robot, faults=faults)
    replayed = replay(recording)
    assert replayed.deviation is None
    assert replayed.is_exact
    assert recording.result
    assert replayed.trace_sha256 == recording.result.trace_sha256


@pytest.mark.parametrize("robot", ["freenove-4wd", "picar"])
def test_app_runs_on_the_recorded_samples(robot: str) -> None:
    recording = record_run(APP, robot=robot)
    result = run(RunRequest(Weave, backend="replay", options={"recording": recording}))
    assert result.outcome is Outcome.SUCCESS
