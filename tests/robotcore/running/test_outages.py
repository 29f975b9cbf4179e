"""Devices that are lost and come back: the robot stands meanwhile, and the run goes on, where it may."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import pytest

from robotcore import Outcome, RunRequest, RunResult
from robotcore.geometry import Pose
from robotcore.replay import replay
from robotcore.running.session import Run, run
from robotcore.running.trace import TickRecord
from tests.robotcore.replay.memory import Memory


class Watching:
    """Where the robot was, and for what it waited, at each tick."""

    def __init__(self) -> None:
        self.lost: list[str | None] = []
        self.poses: list[Pose] = []
        self._run: Run | None = None

    def begin(self, run: Run) -> None:
        self._run = run

    def tick(self, record: TickRecord) -> None:
        assert self._run
        assert self._run.truth
        self.lost.append(record.lost)
        self.poses.append(self._run.truth.pose)

    def end(self, result: RunResult) -> None:
        """Nothing more is seen."""


@pytest.fixture
def patient(tmp_path: Path) -> str:
    """A rover that waits a second for what is lost."""
    file = tmp_path / "rover.toml"
    rover = (resources.files("robotcore.description") / "robots/rover.toml").read_text()
    file.write_text(rover.replace("[safety]", "[safety]\noutage_s = 1.0"))
    return str(file)


def search(robot: str, *faults: str, watching: Watching | None = None) -> RunResult:
    request = RunRequest("green-search", robot=robot, seed=7, timeout_s=4.0, faults=faults)
    return run(request, [watching] if watching else [])


@pytest.mark.parametrize("target", ["range", "drive", "encoders", "camera", "connection"])
def test_a_run_goes_on_when_what_was_lost_is_back(patient: str, target: str) -> None:
    result = search(patient, f"{target} lost=0.5 after=1")
    assert (result.outcome, result.sim_time_s) == (Outcome.TIMEOUT, 4.0)
    [note] = result.notes
    assert "was lost once, 0.5 s in all, and came back; the robot stood meanwhile" in note


def test_the_robot_stands_until_it_is_back(patient: str) -> None:
    watching = Watching()
    search(patient, "range lost=0.8 after=1", watching=watching)
    waiting = [pose for pose, lost in zip(watching.poses, watching.lost, strict=True) if lost == "nose"]
    assert len(waiting) == 16
    assert waiting[10].heading == pytest.approx(waiting[-1].heading, abs=1e-3)
    assert watching.poses[-1].heading != pytest.approx(waiting[-1].heading, abs=0.1)


def test_each_loss_has_the_whole_time_again(patient: str) -> None:
    result = search(patient, "range lost=0.6 after=0.5 every=1")
    assert result.outcome is Outcome.TIMEOUT
    assert result.notes == ["nose was lost 3 times, 1.8 s in all, and came back; the robot stood meanwhile"]


def test_what_stays_away_for_too_long_ends_the_run_by_its_name(patient: str) -> None:
    result = search(patient, "range lost=2 after=1")
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert result.reason.startswith("nose: the connection is lost")
    assert result.sim_time_s == pytest.approx(2.0)


def test_without_a_word_of_it_a_loss_ends_the_run_at_once() -> None:
    result = search("rover", "range lost=0.1 after=1")
    assert result.exit_status == 3
    assert result.sim_time_s == pytest.approx(1.0)


def test_a_recorded_loss_is_replayed_with_the_same_decisions(patient: str) -> None:
    memory = Memory()
    request = RunRequest("green-search", robot=patient, seed=7, timeout_s=4.0, faults=("connection lost=0.5 after=1",))
    run(request, [memory], [memory.tap])
    verdict = replay(memory.recording)
    assert verdict.exit_status == 0
    assert verdict.result.ticks == len(memory.ticks)
