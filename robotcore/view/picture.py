"""Draw a run as one picture: the world from above, the last picture of the camera, the states and their times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from robotcore.canvas import (
    BAD,
    FADED,
    FAIR,
    GOOD,
    INK,
    RULE,
    Canvas,
    Colour,
    choose_state_colours,
    encode_png,
    measure_text,
    shorten_text,
)
from robotcore.description import Floor, RobotDescription, WorldDescription
from robotcore.geometry import Pose
from robotcore.hal.robot import Robot
from robotcore.kinds.camera import Frame
from robotcore.kinds.display import Display
from robotcore.optics import Image
from robotcore.recording import Recording, Tick
from robotcore.recording.summary import build_odometry_path, build_result, build_true_path
from robotcore.runtime.layers.devices import AppActuator, AppSensor
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.session import RunContext
from robotcore.runtime.trace import TickRecord
from robotcore.view.overhead import MapPath, Track, TrackPoint, draw_map, draw_ring
from robotcore.view.page import EDGE, HEIGHT, MAP, SIDE, SIDE_WIDTH, TOP, begin_page, finish_page, save_png
from robotcore.view.text import format_evaluation_heading, format_heading, list_interventions, list_measures

_SIDE_HEIGHT = 560
_LEGEND_ROW = 36

_OUTCOME_COLOURS: dict[Outcome, Colour] = {
    Outcome.SUCCESS: GOOD,
    Outcome.TIMEOUT: FAIR,
    Outcome.INTERRUPTED: FAIR,
}


@dataclass(frozen=True, eq=False)
class RunFigure:
    """The content of the picture of a run."""

    robot: RobotDescription
    world: WorldDescription | None
    """The world; None if its description is unknown."""
    track: Track
    last_picture: Image | None
    """The last picture of a display, else of a camera, BGR or grey; None if there was none."""
    result: RunResult
    recorded: RunResult | None = None
    """The recorded run, if ``result`` is the result of another app on its samples; otherwise None."""


def draw_figure(figure: RunFigure) -> Image:
    """Return the picture of a run: BGR, 1600 pixels wide and 1000 high."""
    colours = choose_state_colours(figure.track.states)
    side_picture = draw_side_picture(figure.last_picture)
    canvas = begin_page(*_format_title(figure))
    _draw_legend(canvas, TOP + len(side_picture), figure, colours)
    return finish_page(canvas, _draw_map(figure, colours), side_picture)


def _format_title(figure: RunFigure) -> tuple[str, str, Colour, str]:
    result = figure.result
    if figure.recorded:
        words = f"decisions of {result.sim_time_s:.1f} s, drawn along the recorded path"
        return format_evaluation_heading(result, figure.recorded), "evaluation", FAIR, words
    colour = BAD if result.dispute else _OUTCOME_COLOURS.get(result.outcome, BAD)
    return format_heading(result), result.headline, colour, ", ".join(list_measures(result))


def _draw_map(figure: RunFigure, colours: dict[str, Colour]) -> Image:
    if figure.world is None:
        return _draw_blank(MAP, MAP, "no description of a world")
    return draw_map(figure.world, [MapPath(figure.robot, figure.track, figure.result.milestones, colours)], MAP)


def draw_side_picture(image: Image | None, missing: str = "the app read no camera") -> Image:
    """Return a picture in the size of the column beside the map; without a picture, the words ``missing`` on grey."""
    if image is None:
        return _draw_blank(SIDE_WIDTH, SIDE_WIDTH * 3 // 4, missing)
    height, width = image.shape[:2]
    scale = min(SIDE_WIDTH / width, _SIDE_HEIGHT / height)
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    colour = image if image.ndim == 3 else cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    return np.asarray(cv2.resize(colour, size, interpolation=cv2.INTER_CUBIC), np.uint8)


def _draw_blank(width: int, height: int, words: str) -> Image:
    canvas = Canvas(width, height, RULE)
    canvas.write_text(((width - measure_text(words, 15)) / 2, height / 2), words, FADED, 15)
    return canvas.render()


def _draw_legend(canvas: Canvas, top: int, figure: RunFigure, colours: dict[str, Colour]) -> None:
    columns = (SIDE + 84.0, SIDE + SIDE_WIDTH - 230.0, SIDE + SIDE_WIDTH - 80.0)
    y = top + 44.0
    for x, words in zip(columns, ("state", "reached", "lasted"), strict=True):
        canvas.write_text((x, y), words, FADED, 13)
    canvas.draw_line([(SIDE, y + 14), (SIDE + SIDE_WIDTH, y + 14)], RULE, 1)
    y += 8
    held = list(list_interventions(figure.result.intervention_s))
    for state, reached, lasted in figure.track.list_state_durations():
        if y + _LEGEND_ROW * (1 + len(held)) > HEIGHT - EDGE:
            break
        y += _LEGEND_ROW
        canvas.draw_line([(SIDE + 6, y - 7), (SIDE + 58, y - 7)], colours[state], 7)
        if state in figure.result.milestones:
            draw_ring(canvas, (SIDE + 32, y - 7), 11, colours[state])
        name = shorten_text(state, columns[1] - columns[0] - 12, 15)
        for x, words in zip(columns, (name, f"{reached:.1f} s", f"{lasted:.1f} s"), strict=True):
            canvas.write_text((x, y), words, INK, 15)
    for index, words in enumerate(held, 1):
        canvas.write_text((columns[0], y + _LEGEND_ROW * index), words, INK, 15)


ORIGIN = Pose(0.0, 0.0, 0.0)

_PATH_MARGIN_M = 0.5
"""The margin around the path on the floor of `build_empty_world`, in metres."""

_LARGEST_FLOOR_M = 100.0
"""The longest side of the floor of `build_empty_world`, in metres. A longer path leaves this floor."""


def build_figure(
    recording: Recording,
    states: Sequence[str] | None = None,
    result: RunResult | None = None,
    *,
    is_evaluation: bool = False,
) -> RunFigure:
    """Return the figure of a recording, with the true path if it is recorded, else the path by odometry.

    recording: the recording.
    states: the state in each tick of a replay or evaluation; None for the recorded states.
    result: the result of the replay or evaluation; None for the recorded result.
    is_evaluation: whether ``states`` and ``result`` are those of another app on the recorded samples.
    """
    about, path = recording.metadata, build_true_path(recording) or build_odometry_path(recording)
    track = Track()
    track.is_located = bool(path)
    shown_states = [tick.state for tick in recording.ticks] if states is None else states
    ticks = recording.ticks[: len(shown_states)]
    for tick, state in zip(ticks, shown_states, strict=False):
        if pose := path.get(tick.number) if path else ORIGIN:
            track.points.append(TrackPoint(tick.time, state, pose))
    recorded = build_result(recording)
    ended = replace(result, world=recorded.world) if result else recorded
    world, image = build_world(recording, track.points), find_last_recorded_picture(recording, ticks)
    return RunFigure(about.description, world, track, image, ended, recorded if is_evaluation else None)


def find_last_recorded_picture(recording: Recording, ticks: Sequence[Tick]) -> Image | None:
    """Return the last picture that a display showed in these ticks, else that of a camera, else None."""
    shown = [each.key for tick in ticks for each in tick.shown]
    read = [each.key for tick in ticks for each in tick.reads]
    for key in (*reversed(shown), *reversed(read)):
        sample = recording.samples.get(key) if key else None
        if isinstance(sample, Frame):
            return sample.image
    return None


def build_world(recording: Recording, points: Sequence[TrackPoint]) -> WorldDescription:
    """Return the recorded world. If there is none, return a world whose floor is large enough for the points."""
    return recording.metadata.world or build_empty_world([step.pose for step in points])


def build_empty_world(poses: Sequence[Pose]) -> WorldDescription:
    """Return a world without things, whose floor is large enough for the poses."""
    reach = max((max(abs(pose.x), abs(pose.y)) for pose in poses), default=0.0)
    side = min(2 * (reach + _PATH_MARGIN_M), _LARGEST_FLOOR_M)
    return WorldDescription(name="floor", floor=Floor(length_m=side, width_m=side))


class PictureRecorder:
    """An observer that draws a picture of its run, with the true path and the last picture of a display or a camera.

    >>> from robotcore import RunRequest, run
    >>> recorder = PictureRecorder()
    >>> result = run(RunRequest("avoid-obstacles", world="open", settings={"duration_s": 1}), [recorder])
    >>> recorder
    <PictureRecorder of 21 points, ended>
    >>> recorder.png()[1:4]
    b'PNG'
    """

    def __init__(self) -> None:
        self._run: RunContext | None = None
        self._track = Track()
        self._figure: RunFigure | None = None

    def __repr__(self) -> str:
        state = "ended" if self._figure else "running" if self._run else "not begun"
        return f"<PictureRecorder of {len(self._track.points)} points, {state}>"

    def begin(self, run: RunContext) -> None:
        self._run = run

    def tick(self, record: TickRecord) -> None:
        if self._run:
            truth = self._run.truth
            self._track.is_located = truth is not None
            points = self._track.points
            if truth is None and [each.state for each in points[-2:]] == [record.state] * 2:
                points.pop()  # without poses, the first and the last point of each state are enough
            points.append(TrackPoint(record.time, record.state, truth.pose if truth else ORIGIN))

    def end(self, result: RunResult) -> None:
        if run := self._run:
            self._figure = RunFigure(run.description, run.world, self._track, find_last_picture(run.robot), result)

    def png(self) -> bytes | None:
        """Return the picture as PNG; None if no run began."""
        return None if self._figure is None else draw_png(self._figure)

    def save(self, file: Path) -> bool:
        """Write the picture as PNG, and return True. If no run began, write nothing and return False.

        Raises UsageError if the file cannot be written.
        """
        content = self.png()
        if content is None:
            return False
        save_png(content, file)
        return True


def draw_png(figure: RunFigure) -> bytes:
    """Return the picture of a run as PNG."""
    return encode_png(draw_figure(figure))


def find_last_picture(robot: Robot) -> Image | None:
    """Return the last picture that a display showed, else that of a camera, else None. This reads no device."""
    devices = robot.devices.values()
    shown = [each.latest for each in devices if isinstance(each, AppActuator) and isinstance(each, Display)]
    read = [each.latest.image for each in devices if isinstance(each, AppSensor) and isinstance(each.latest, Frame)]
    return next((image for image in (*shown, *read) if image is not None), None)
