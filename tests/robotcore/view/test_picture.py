"""Pictures of runs."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from robotcore import RunRequest, run
from robotcore.canvas import BAD, FAIR, GOOD, Canvas, choose_state_colours, measure_text
from robotcore.errors import UsageError
from robotcore.geometry import Pose
from robotcore.kinds.camera import Frame
from robotcore.optics import Image
from robotcore.runtime.layers.devices import AppActuator, AppSensor
from robotcore.runtime.session import RunContext
from robotcore.view import page
from robotcore.view.overhead import MapTransform, Track, TrackPoint
from robotcore.view.page import EDGE, HEIGHT, MAP, SIDE, TOP, begin_page, join_titles, require_writable
from robotcore.view.picture import (
    PictureRecorder,
    RunFigure,
    _format_title,
    build_figure,
    draw_figure,
    find_last_picture,
)
from robotcore.view.text import list_interventions
from tests.robotcore.description.courses import COURSE, QUADRANTS, load_course
from tests.robotcore.recording.replay.memory import record_run
from tests.texts import Raises

Rgb = tuple[int, int, int]


def list_colours_near(image: Image, x: float, y: float, reach: int = 2) -> list[Rgb]:
    """Return the colours around a pixel, red first."""
    column, row = round(x), round(y)
    patch = image[row - reach : row + reach + 1, column - reach : column + reach + 1, ::-1].reshape(-1, 3)
    return [(int(red), int(green), int(blue)) for red, green, blue in patch]


@pytest.mark.slow
@pytest.mark.parametrize("scale", [1, 60], ids=["enlarged", "shrunk"])
def test_picture_on_the_floor_is_drawn(figure: RunFigure, tmp_path: Path, scale: int) -> None:
    lines = "[[lines]]\nwidth_m = 0.1\npoints_m = [[0.0, -0.4], [1.0, -0.4]]\n"
    world = load_course(tmp_path, np.kron(QUADRANTS, np.ones((scale, scale, 1), np.uint8)), COURSE + lines)
    image = draw_figure(dataclasses.replace(figure, world=world))
    figure = dataclasses.replace(figure, world=world)
    colours = {(0.6, 0.1): (0, 255, 0), (1.2, -0.7): (255, 255, 255), (0.5, -0.4): (25, 25, 25)}
    colours |= {(1.3, 0.1): (200, 190, 180), (1.2, 0.3): (200, 190, 180)}
    for place, colour in colours.items():
        assert set(list_colours_near(image, *find_pixel(figure, *place), reach=1)) == {colour}


def test_long_picture_far_beyond_the_canvas_is_drawn() -> None:
    canvas = Canvas(64, 48, (1, 2, 3))
    canvas.draw_picture(np.full((1, 100_000, 3), (30, 20, 10), np.uint8), (-90_000.0, 10.0), (90_000.0, 20.0))
    image = canvas.render()
    assert (image[11:19] == (30, 20, 10)).all()
    assert (image[21:] == (3, 2, 1)).all()


def find_pixel(figure: RunFigure, x: float, y: float) -> tuple[float, float]:
    """Return the pixel of the picture that shows a point of the world."""
    assert figure.world
    column, row = MapTransform.fit(figure.world, figure.track.points, MAP).to_pixel(x, y)
    return column + EDGE, row + TOP


@pytest.mark.slow
def test_ball_obstacles_robot_and_path_are_drawn_in_their_colours(figure: RunFigure) -> None:
    assert figure.world
    assert figure.world.target
    image = draw_figure(figure)
    for thing in (figure.world.target, *figure.world.obstacles):
        assert thing.colour in list_colours_near(image, *find_pixel(figure, thing.x_m, thing.y_m))
    belly = figure.track.points[-1].pose.to_world(0.05, 0.06)
    assert figure.robot.body.colour in list_colours_near(image, *find_pixel(figure, *belly))
    colours = choose_state_colours(figure.track.states)
    for step in figure.track.points[16:34:4]:
        assert colours[step.state] in list_colours_near(image, *find_pixel(figure, step.pose.x, step.pose.y), reach=4)


@pytest.mark.slow
def test_milestones_at_one_pose_do_not_hide_each_other(figure: RunFigure) -> None:
    figure.track.points = [step._replace(pose=figure.track.points[0].pose) for step in figure.track.points]
    image = draw_figure(figure)
    x, y = find_pixel(figure, *figure.track.points[0].pose[:2])
    row = {tuple(int(part) for part in pixel) for pixel in image[round(y), round(x) : round(x) + 90, ::-1]}
    assert set(choose_state_colours(figure.track.states).values()) <= row


def test_the_map_shows_a_robot_that_left_the_floor(figure: RunFigure) -> None:
    far = figure.track.points[-1].pose._replace(x=5.0, y=-0.3)
    figure.track.points.append(figure.track.points[-1]._replace(pose=far))
    x, _ = find_pixel(figure, far.x + figure.robot.body.reach_m, far.y)
    assert x < EDGE + MAP


@pytest.mark.slow
@pytest.mark.parametrize("shape", [(240, 320, 3), (240, 320), (480, 320, 3)])
def test_the_last_picture_is_beside_the_map_in_colour_or_grey(figure: RunFigure, shape: tuple[int, ...]) -> None:
    seen = np.full(shape, 77, np.uint8)
    image = draw_figure(dataclasses.replace(figure, last_picture=seen))
    assert list_colours_near(image, SIDE + 40, TOP + 40) == [(77, 77, 77)] * 25


@pytest.mark.parametrize(
    "changes, is_evaluation, colour",
    [
        ({"verified": True}, False, GOOD),
        ({"verified": None}, False, GOOD),
        ({"verified": False, "contacts": 2}, False, BAD),
        ({}, True, FAIR),
    ],
)
def test_the_title_has_the_colour_of_the_verdict(
    figure: RunFigure, changes: dict[str, Any], is_evaluation: bool, colour: Rgb
) -> None:
    result = dataclasses.replace(figure.result, **changes)
    judged = dataclasses.replace(figure, result=result, recorded=result if is_evaluation else None)
    title = draw_figure(judged)[80:TOP, :, ::-1]
    assert [each for each in (GOOD, BAD, FAIR) if (title == each).all(axis=2).any()] == [colour]
    assert is_evaluation or _format_title(judged)[1] == result.headline


@pytest.mark.parametrize("states", [4, 12])
def test_the_legend_has_a_line_for_each_named_intervention(
    figure: RunFigure, monkeypatch: pytest.MonkeyPatch, states: int
) -> None:
    lines: dict[str, float] = {}

    class RecordedCanvas(Canvas):
        def write_text(self, place: tuple[float, float], words: str, *style: Any, **more: Any) -> float:
            lines[words] = place[1]
            return super().write_text(place, words, *style, **more)

    monkeypatch.setattr(page, "Canvas", RecordedCanvas)
    figure.track.points = [
        step._replace(state=f"state {at * states // 40}") for at, step in enumerate(figure.track.points)
    ]
    held = {"acceleration limit": 3.0, "range guard": 15.0, "lost device": 0.499, "deadman": 1.25}
    draw_figure(dataclasses.replace(figure, result=dataclasses.replace(figure.result, intervention_s=held)))
    causes = [words for words in lines if "held" in words]
    assert causes == list(list_interventions(held))
    heights = [lines[words] for words in lines if words in causes or words.startswith("state ")]
    assert heights == sorted(set(heights))
    assert heights[-1] <= HEIGHT - EDGE


def test_a_run_without_camera_world_and_truth_has_a_picture(figure: RunFigure) -> None:
    bare = RunFigure(figure.robot, None, Track(), None, figure.result)
    assert draw_figure(bare).shape == (1000, 1600, 3)


def test_a_state_has_the_same_colour_in_every_picture_and_colours_repeat_after_eight() -> None:
    states = ["search", "seen", "explore", "approach", "survey", "avoid", "retreat", "arrived"]
    colours = choose_state_colours(states)
    assert len(set(colours.values())) == len(states)
    for part in (["seen"], states[:2:-1]):
        assert choose_state_colours(part) == {name: colours[name] for name in part}
    assert len(set(choose_state_colours([str(number) for number in range(20)]).values())) == 8


@pytest.mark.parametrize("words", ["", "w" * 300])
def test_a_long_title_is_shortened_to_the_width_of_the_page(words: str) -> None:
    for heading in ("h" * 300, join_titles(*["h" * 200] * 2)):
        title = begin_page(heading, "differ", BAD, words).render()[:TOP]
        assert (title[:, -EDGE:] == title[0, 0]).all()
        assert (title[:, -4 * EDGE : -EDGE] != title[0, 0]).any()
    assert join_titles("a", "b") == "a  and  b"


def test_a_replay_that_ends_early_has_the_last_picture_before_its_end() -> None:
    recording = record_run("green-search", seed=3, timeout_s=0.5)
    pictures = []
    for tick in (recording.ticks[1], recording.ticks[-1]):
        key = tick.shown[-1].key
        assert key
        shown = recording.samples[key]
        assert isinstance(shown, Frame)
        pictures.append(shown.image)
    assert build_figure(recording, states=["search"] * 2).last_picture is pictures[0]
    assert build_figure(recording).last_picture is pictures[1] is not pictures[0]


class RunKeeper(PictureRecorder):
    """A recorder that also stores the run."""

    def begin(self, run: RunContext) -> None:
        super().begin(run)
        self.run = run


def test_the_recorder_stores_the_true_pose_of_every_tick_and_reads_no_camera() -> None:
    recorder = RunKeeper()
    result = run(RunRequest("avoid-obstacles", world="open", settings={"duration_s": 8.0}), [recorder])
    assert recorder.run.world
    steps = recorder._track.points
    assert len(steps) == result.ticks
    assert steps[0].pose == recorder.run.world.start.pose
    assert steps[-1].pose.distance_to(*steps[0].pose[:2]) > 0.01
    assert find_last_picture(recorder.run.robot) is None


def test_the_picture_on_a_display_comes_before_the_camera_image() -> None:
    recorder = RunKeeper()
    run(RunRequest("mark-green", world="open", seed=3, settings={"duration_s": 0.5}), [recorder])
    robot = recorder.run.robot
    assert isinstance(robot.display, AppActuator)
    assert isinstance(robot.camera, AppSensor)
    assert robot.camera.latest is not None
    assert find_last_picture(robot) is robot.display.latest is not robot.camera.latest.image


def test_a_run_without_truth_has_a_picture_with_its_states(raises: Raises, tmp_path: Path) -> None:
    recorder = PictureRecorder()
    result = run(RunRequest("mark-green", "mock", settings={"duration_s": 0.2}), [recorder])
    require_writable(tmp_path / "run.png")
    assert not list(tmp_path.iterdir())
    recorder.save(tmp_path / "run.png")
    picture = cv2.imread(str(tmp_path / "run.png"))
    assert picture is not None
    assert picture.shape == (1000, 1600, 3)
    with raises(UsageError, "file-not-writable"):
        recorder.save(tmp_path / "missing" / "run.png")
    assert recorder._figure
    assert not recorder._figure.track.is_located
    assert len(recorder._figure.track.points) == 2
    ((state, first_s, duration_s),) = recorder._figure.track.list_state_durations()
    assert (state, first_s) == ("search", 0.0)
    assert duration_s == pytest.approx(result.sim_time_s)


def test_a_track_has_the_segments_the_durations_and_the_milestones_of_its_states() -> None:
    track = Track()
    assert track.find_milestone_poses({"a": 0.0}) == {}
    track.points = [TrackPoint(float(time), state, Pose(time, 0.0, 0.0)) for time, state in enumerate("aabba")]
    assert track.states == ["a", "b"]
    times = [(state, [step.time for step in steps]) for state, steps in track.list_segments()]
    assert times == [("a", [0, 1]), ("b", [1, 2, 3]), ("a", [3, 4])]
    assert list(track.list_state_durations()) == [("a", 0.0, 2.0), ("b", 2.0, 2.0)]
    assert track.find_milestone_poses({"b": 2.2}) == {"b": Pose(2, 0.0, 0.0)}


def test_text_that_opencv_cannot_write_is_drawn_as_its_escape() -> None:
    sheets = []
    for words in ("\ud800", r"\ud800"):
        sheets.append(Canvas(100, 40, (255, 255, 255)))
        assert sheets[-1].write_text((5, 30), words, (0, 0, 0), 12) == measure_text(words, 12) > 0
    assert np.array_equal(sheets[0].render(), sheets[1].render())
