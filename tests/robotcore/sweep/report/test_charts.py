"""Charts, maps and figures of the report."""

from __future__ import annotations

import math
import re
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from robotcore.description import load_world
from robotcore.sweep.failure_analysis import explain
from robotcore.sweep.report.charts import MAX_STEPS, plot_arrivals, plot_condition, plot_success
from robotcore.sweep.report.failures import MAX_ENDINGS, count_endings
from robotcore.sweep.report.maps import draw_maps
from robotcore.sweep.report.series import build_series, find_goal, list_milestones
from robotcore.sweep.statistics import compare_backends, group_records
from tests.robotcore.description.courses import load_course
from tests.robotcore.sweep.report.samples import PATH, make_fail, make_many, make_pass

ARENA = {"arena": load_world("arena")}


def test_a_share_is_a_dot_within_its_interval_and_a_group_without_a_judge_has_none() -> None:
    unjudged = [make_pass(world="lab", verified=None)]
    root = _parse(plot_success(group_records([*make_many(10, failing=4), *unjudged])))
    (bar,) = root.iterfind(".//line[@class='interval']")
    (dot,) = root.iter("circle")
    assert float(bar.attrib["x1"]) < float(dot.attrib["cx"]) < float(bar.attrib["x2"])
    assert {"6/10", "?/1"} <= {each.text for each in root.iter("text")}
    assert plot_success(group_records(unjudged)) == ""


def test_the_curve_of_many_runs_has_few_steps_and_the_same_end() -> None:
    records = [make_pass(milestones={"arrived": float(at)}) for at in range(1, 1200)] + [make_fail()]
    curve = _find_lines(plot_arrivals(build_series(records), "arrived"), "curve c0 d0")[0]
    assert len(curve) <= 2 * MAX_STEPS + 4
    assert curve[-1][1] == pytest.approx(10.2, abs=0.05)


def test_north_is_up_in_a_map_and_failing_paths_are_a_group() -> None:
    (chart,) = draw_maps(build_series([make_pass(), make_fail(path=PATH[:2])]), ARENA)
    ((way,), (short,)) = (_find_lines(chart.drawing, f"paths {kind}") for kind in ("passing", "failing"))
    assert [x for x, _ in way] == sorted(x for x, _ in way)
    assert [y for _, y in way] == sorted((y for _, y in way), reverse=True)
    assert way[2][0] - way[1][0] == way[1][1] - way[2][1] == 100  # centimetres
    assert len(short) == 2
    assert chart.caption == "passing runs: 1, failing: 1"


@pytest.mark.parametrize("seed, obstacles", [(None, 6), (7, 0)])
def test_obstacles_are_drawn_only_if_no_seed_moved_them(seed: int | None, obstacles: int) -> None:
    (chart,) = draw_maps(build_series([make_pass(seed=seed)]), ARENA)
    assert chart.drawing.count('class="obstacle"') == obstacles
    assert 'class="floor"' in chart.drawing


def test_picture_on_the_floor_is_drawn_below_the_paths(tmp_path: Path) -> None:
    world = load_course(tmp_path)
    (chart,) = draw_maps(build_series([make_pass(world="course")]), {"course": world})
    tags = [each.tag.rpartition("}")[2] for each in _parse(chart.drawing).iter()]
    (picture,) = [each for each in _parse(chart.drawing).iter() if each.tag.endswith("image")]
    size = {key: float(picture.attrib[key]) for key in ("x", "y", "width", "height")}
    assert size == {"x": 200 - 25 + 12, "y": 200 - 25 + 12, "width": 150, "height": 100}
    assert world.floor.image
    assert picture.attrib["href"] == f"data:image/png;base64,{world.floor.image.content}"
    assert tags.index("image") < tags.index("path")


def test_a_path_off_the_floor_stays_in_the_drawing_and_one_with_nan_is_left_out() -> None:
    nan = make_fail(path=((0.0, math.nan, 0.0),))
    far = make_pass(path=((0.0, 0.0, 0.0), (1.0, 9.0, -5.0)))
    (chart,) = draw_maps(build_series([far, nan, make_pass(world="open", path=None)]), ARENA)
    _, _, width, height = map(float, _parse(chart.drawing).attrib["viewBox"].split())
    assert all(0 < x < width and 0 < y < height for x, y in _find_lines(chart.drawing, "paths passing")[0])
    assert chart.caption == "passing runs: 1, failing: 0"


@pytest.mark.parametrize("is_dark, start, end", [(True, 64, 255), (False, 255, 446)])
def test_the_side_on_which_runs_fail_is_marked(is_dark: bool, start: float, end: float) -> None:
    dark, bright = (make_fail, make_pass) if is_dark else (make_pass, make_fail)
    records = [make(conditions={"light": light}) for make, light in ((dark, 0.0), (bright, 1.0)) for _ in range(9)]
    (split,) = explain(records).splits
    root = _parse(plot_condition(split, [*records, make_fail(backend="pybullet", conditions={"light": 0.5})]))
    (side,) = root.iter("rect")
    left, width = float(side.attrib["x"]), float(side.attrib["width"])
    assert (left, left + width) == (start, end)
    assert len(root.findall(".//g[@class='rug failing']/line")) == 9


def test_a_condition_that_is_a_word_is_not_drawn() -> None:
    records = [
        make(conditions={"floor": floor})
        for make, floor in ((make_fail, "wood"), (make_pass, "tiles"))
        for _ in "123456789"
    ]
    (split, *_) = explain(records).splits
    assert plot_condition(split, records) == ""


def test_runs_are_grouped_and_a_world_has_a_colour_and_a_backend_its_dashes() -> None:
    records = [make_pass(world=world, backend=backend) for world in ("arena", "open") for backend in "ab"]
    styles = {each.group.name: each.style for each in build_series([*records, records[0]])}
    assert styles == {"arena · a": "c0 d0", "arena · b": "c0 d1", "open · a": "c1 d0", "open · b": "c1 d1"}
    assert [each.style for each in build_series(records[:2])] == ["c0 d0", "c1 d1"]


def test_the_goal_is_the_last_milestone_of_passing_runs() -> None:
    series = build_series([make_pass(), make_pass(), make_fail(milestones={"lost": 90.0, "search": 0.0})])
    assert list_milestones(series) == ["search", "seen", "arrived", "lost"]
    assert find_goal(series, ["search", "seen", "arrived", "lost"]) == "arrived"
    lost = build_series([make_fail(milestones={"search": 0.0, "seen": 3.0})])
    assert find_goal(lost, ["search", "seen"]) == "seen"
    assert find_goal(build_series([make_fail(milestones={"search": 0.0})]), ["search"]) is None
    assert find_goal([], []) is None


def test_backends_are_compared_by_the_runs_that_both_have() -> None:
    records = [
        make_pass(seed=1),
        make_pass(seed=2),
        make_pass(seed=3),
        make_pass(seed=4),
        make_pass(seed=1, backend="pybullet"),
        make_fail(seed=2, backend="pybullet"),
        make_pass(seed=3, backend="pybullet", milestones={"seen": 1.0, "search": 2.0, "arrived": 9.0}),
        make_pass(seed=4, backend="pybullet", world="clutter"),
        make_pass(seed=9, backend="mujoco"),
    ]
    (agreement,) = compare_backends(records)
    assert (len(agreement.pairs), agreement.same_outcome, agreement.same_milestones) == (3, 2, 1)
    assert [first.seed for first, _ in agreement.differing] == [2, 3]


def test_endings_are_counted_by_group_and_rare_ones_are_one_row() -> None:
    records = [
        *(make_fail(reason="late", seed=seed) for seed in (1, 2)),
        make_fail(reason="late", world="clutter"),
        make_pass(contacts=1),
        make_pass(contacts=7),
        make_pass(),
    ]
    common = [("timeout, late", [2, 1]), ("contact", [2, 0])]
    assert count_endings(build_series(records)) == common
    rare = count_endings(build_series([*records, *(make_fail(reason=f"lost at {at} m") for at in range(20))]))
    assert rare[:2] == common
    assert rare[MAX_ENDINGS:] == [("in 10 other ways", [10, 0])]


def _parse(drawing: str) -> ET.Element:
    return ET.fromstring(drawing)  # noqa: S314  our own drawing


def _find_lines(drawing: str, kind: str) -> list[list[tuple[float, float]]]:
    """Return the corners of each line with a CSS class, or in a group with this class."""
    root = _parse(drawing)
    ways = [*root.iterfind(f".//path[@class='{kind}']"), *root.iterfind(f".//g[@class='{kind}']/path")]
    return [[(float(x), float(y)) for x, y in re.findall(r"[ML](\S+?) ([^ML]+)", way.attrib["d"])] for way in ways]
