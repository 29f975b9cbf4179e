from __future__ import annotations

import pytest

from robotcore import Outcome, RunResult
from robotcore.description import load_robot, load_world
from robotcore.view.overhead import Track, TrackPoint
from robotcore.view.picture import RunFigure

STATES = ("search", "seen", "approach", "arrived")


@pytest.fixture
def track() -> Track:
    """Build a track in the arena with ten ticks in each state. The robot does not move in the first state."""
    start = load_world("arena").start.pose._replace(heading=0.6)
    track = Track()
    for tick in range(10 * len(STATES)):
        state = STATES[tick // 10]
        pose = start.advance(max(0, tick - 10) * 0.02, 0.0)
        track.points.append(TrackPoint(tick / 20, state, pose))
    return track


@pytest.fixture
def result() -> RunResult:
    milestones = {state: index / 2 for index, state in enumerate(STATES)}
    return RunResult(
        "green-search", "kinematic", "rover", "arena", 7, Outcome.SUCCESS, 0, verified=True, milestones=milestones
    )


@pytest.fixture
def figure(track: Track, result: RunResult) -> RunFigure:
    return RunFigure(load_robot("rover"), load_world("arena"), track, None, result)
