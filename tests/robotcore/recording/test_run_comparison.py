"""Comparison of two recordings."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from robotcore.description import Line, WorldDescription
from robotcore.geometry import Pose
from robotcore.recording import GroundTruthSample, Recording
from robotcore.recording.run_comparison import Comparison, RunSummary, StateDifference
from robotcore.recording.summary import measure_path
from robotcore.runtime.result import Outcome
from robotcore.view.comparison_view import FIRST, SECOND, build_rows, draw_comparison, format_comparison
from tests.robotcore.description.courses import encode_png, load_course
from tests.robotcore.recording.replay.memory import change_tick, record_run
from tests.texts import CheckText


@pytest.fixture(scope="module")
def run() -> Recording:
    return record_run("avoid-obstacles", seed=1, settings={"duration_s": 15})


@pytest.fixture(scope="module")
def other() -> Recording:
    return record_run("avoid-obstacles", seed=2, settings={"duration_s": 15})


def compare(first: Recording, second: Recording) -> Comparison:
    return Comparison(RunSummary("a.mcap", first), RunSummary("b.mcap", second))


def format_heading(comparison: Comparison) -> str:
    """Return the lines above the table."""
    console = Console(width=200)
    with console.capture() as capture:
        console.print(format_comparison(comparison))
    return capture.get().partition("\n\n")[0]


def with_world(recording: Recording, world: WorldDescription | None) -> Recording:
    return replace(recording, metadata=replace(recording.metadata, world=world))


def with_milestones(recording: Recording, **milestones: float) -> Recording:
    assert recording.result
    return replace(recording, result=replace(recording.result, milestones=milestones))


@pytest.mark.parametrize(
    "second, difference",
    [
        ({"seen": 1.5, "near": 9.0}, None),
        ({"near": 1.0, "seen": 2.0}, ("seen", "near")),
        ({"seen": 1.0}, ("near", None)),
    ],
)
def test_order_of_milestones_must_be_the_same_and_times_may_differ(
    run: Recording, second: dict[str, float], difference: tuple[str, str | None] | None, check_text: CheckText
) -> None:
    comparison = compare(with_milestones(run, seen=1.0, near=2.0), with_milestones(run, **second))
    assert (comparison.first_other_milestone, comparison.exit_status) == (difference, int(difference is not None))
    check_text(format_heading(comparison))


def test_first_different_state_outcome_or_end_is_reported(run: Recording) -> None:
    assert run.result
    same = compare(run, run)
    assert (same.is_alike, same.exit_status, same.first_difference, same.first_other_milestone) == (True, 0, None, None)
    assert not compare(run, replace(run, result=replace(run.result, outcome=Outcome.TIMEOUT))).is_alike
    lost = change_tick(change_tick(run, 9, state="lost"), 30, state="lost")
    assert compare(run, lost).first_difference == StateDifference(9, run.ticks[9].time, run.ticks[9].state, "lost")
    earlier = compare(run, replace(run, ticks=run.ticks[:20])).first_difference
    assert earlier
    assert (earlier.tick, earlier.second) == (20, None)


@pytest.mark.slow
def test_rooms_that_differ_are_reported_and_drawn(run: Recording, other: Recording, check_text: CheckText) -> None:
    world = run.metadata.world
    assert world
    dark = world.model_copy(update={"name": "dark", "light": world.light.model_copy(update={"ambient": 0.1})})
    for same in (world, dark, None):
        assert compare(run, with_world(run, same)).to_dict()["rooms_differ"] is False
    two = compare(run, other)
    assert two.to_dict()["rooms_differ"] is True
    check_text(format_heading(two))
    same_paths = compare(run, with_world(run, other.metadata.world))
    assert (draw_comparison(same_paths)[:136] != draw_comparison(compare(run, run))[:136]).any()


LINE = Line(width_m=0.02, points_m=((0.0, 0.0), (1.0, 0.0)))


@pytest.mark.parametrize(
    "change, differs",
    [
        ({"file": "renamed.png"}, False),
        ({"content": b64encode(encode_png(np.zeros((4, 6, 3), np.uint8))).decode()}, True),
        ({"x_m": 0.6}, True),
        (None, True),
    ],
    ids=["other name", "other pixels", "moved", "none"],
)
def test_rooms_with_another_picture_on_the_floor_differ(
    run: Recording, tmp_path: Path, change: dict[str, Any] | None, *, differs: bool
) -> None:
    course = load_course(tmp_path)
    assert course.floor.image
    image = None if change is None else course.floor.image.model_copy(update=change)
    other = course.model_copy(update={"floor": course.floor.model_copy(update={"image": image})})
    assert compare(with_world(run, course), with_world(run, other)).has_other_room is differs


def test_rooms_with_another_line_differ(run: Recording) -> None:
    world = run.metadata.world
    assert world
    lined = world.model_copy(update={"lines": (LINE,)})
    assert compare(run, with_world(run, lined)).has_other_room is True


def test_settings_and_faults_of_the_runs_are_rows(run: Recording) -> None:
    other = record_run("avoid-obstacles", seed=1, settings={"duration_s": 1}, faults=("range noise=0.1",))
    rows = {title: texts for title, *texts in build_rows(compare(run, other))}
    assert rows["settings"] == ["duration_s=15", "duration_s=1"]
    assert rows["faults"] == ["–", "range noise=0.1"]


def test_cut_file_is_measured_up_to_its_end(run: Recording) -> None:
    cut = replace(run, ticks=run.ticks[:20], result=None, is_cut=True)
    comparison = compare(run, cut)
    assert (comparison.exit_status, comparison.second.outcome) == (1, "cut")
    assert run.result
    reached = {name: time for name, time in run.result.milestones.items() if time <= cut.ticks[-1].time}
    assert comparison.milestones[1] == reached


def test_paths_are_in_metres_poses_in_the_world_and_drift_is_their_distance(run: Recording) -> None:
    side, last = RunSummary("a", run), run.truth[-1]
    assert measure_path([Pose(0, 0, 0), Pose(3, 4, 1), Pose(3, 4, 2)]) == 5
    first, true = next(iter(side.odometry.values())), next(iter(side.truth.values()))
    assert first == pytest.approx(true, abs=1e-6)
    assert side.drift == pytest.approx(0.0, abs=0.02)
    moved = GroundTruthSample(last.tick, last.time, last.pose._replace(x=last.pose.x + 3.0), 0)
    assert RunSummary("a", replace(run, truth=[*run.truth[:-1], moved])).drift == pytest.approx(3.0, abs=0.02)


def test_values_without_truth_and_drive_are_none(run: Recording) -> None:
    watching = record_run("mark-green", robot="lookout", world="open", seed=3, timeout_s=1.0)
    payload = RunSummary("a", replace(watching, truth=[])).to_dict()
    assert {payload[key] for key in ("odometry_m", "truth_m", "drift_m", "final_odometry")} == {None}
    assert compare(run, replace(watching, truth=[])).to_dict()["alike"] is False


@pytest.mark.parametrize("kind", ["same", "other", "without world"])
def test_picture_shows_both_paths_in_their_colours(run: Recording, other: Recording, kind: str) -> None:
    bare = replace(run, metadata=replace(run.metadata, world=None), truth=[])
    pair = {"same": (run, run), "other": (run, other), "without world": (bare, bare)}[kind]
    image = draw_comparison(compare(*pair))
    assert image.shape == (1000, 1600, 3)
    for colour in (FIRST, SECOND)[kind == "without world" :]:
        assert (np.abs(image[136:, :900].astype(int) - colour[::-1]).max(axis=2) < 8).sum() > 200
