"""The sheet that tells a run: the world from above, what the camera saw last, and the words for both."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from robotcore.description import RobotDescription, WorldDescription
from robotcore.hal.devices import Image
from robotcore.runtime.outcome import Outcome, RunResult
from robotcore.view import overhead
from robotcore.view.canvas import Canvas, Colour, text_width
from robotcore.view.palette import BAD, FADED, FAIR, GOOD, INK, PAPER, RULE, state_colours
from robotcore.view.summary import heading, measures, rehearsed_heading
from robotcore.view.track import Track

WIDTH, HEIGHT = 1600, 1000
_EDGE, _GAP = 44, 40
_TOP = 136
_MAP = HEIGHT - _TOP - _EDGE
_SIDE = _EDGE + _MAP + _GAP
_SIDE_WIDTH = WIDTH - _EDGE - _SIDE
_SEEN_HEIGHT = 560

_OUTCOME_COLOURS: dict[Outcome, Colour] = {
    Outcome.SUCCESS: GOOD,
    Outcome.TIMEOUT: FAIR,
    Outcome.INTERRUPTED: FAIR,
}


@dataclass(frozen=True, eq=False)
class Story:
    """All that is told of a run; ``seen`` is the last picture, BGR or grey, if there was one.

    ``recorded`` is the run on whose samples an app only rehearsed: the track is that run's.
    """

    robot: RobotDescription
    world: WorldDescription | None
    track: Track
    seen: Image | None
    result: RunResult
    recorded: RunResult | None = None


def draw(story: Story) -> Image:
    """Return the sheet: BGR, 1000 x 1600."""
    colours = state_colours(story.track.states)
    seen = _seen(story.seen)
    canvas = Canvas(WIDTH, HEIGHT, PAPER)
    _draw_title(canvas, *_title(story))
    _draw_legend(canvas, _TOP + len(seen), story, colours)
    image = canvas.image()
    _lay(image, _map(story, colours), _EDGE)
    _lay(image, seen, _SIDE)
    return image


def _title(story: Story) -> tuple[str, str, Colour, str]:
    """Return the heading, how it ended in a word, its colour, and what else there is to say."""
    result = story.result
    if story.recorded:
        words = f"{result.sim_time_s:.1f} s of what it would have decided, along the recorded path"
        return rehearsed_heading(result, story.recorded), "rehearsal", FAIR, words
    colour = BAD if result.dispute else _OUTCOME_COLOURS.get(result.outcome, BAD)
    return heading(result), result.outcome.value, colour, ", ".join(measures(result))


def _draw_title(canvas: Canvas, heading: str, word: str, colour: Colour, words: str) -> None:
    canvas.text((_EDGE, 66), heading, INK, 25, bold=True)
    width = canvas.text((_EDGE, 108), word, colour, 17, bold=True)
    canvas.text((_EDGE + width + 18, 108), words, FADED, 17)


def _map(story: Story, colours: dict[str, Colour]) -> Image:
    """Return the world from above with all that happened in it."""
    if story.world is None:
        return _blank(_MAP, _MAP, "no world is described for this robot")
    canvas = Canvas(_MAP, _MAP, PAPER)
    chart = overhead.Chart.fitting(story.world, story.track, _MAP)
    overhead.draw_world(canvas, chart, story.world)
    if steps := story.track.steps:
        overhead.draw_start(canvas, chart, story.robot, steps[0].pose)
        overhead.draw_track(canvas, chart, story.track, colours)
        overhead.draw_robot(canvas, chart, story.robot, steps[-1].pose)
        overhead.draw_milestones(canvas, chart, story.track.places(story.result.milestones), colours)
    return canvas.image()


def _seen(seen: Image | None) -> Image:
    """Return the last picture in colour, as wide as the side of the sheet."""
    if seen is None:
        return _blank(_SIDE_WIDTH, _SIDE_WIDTH * 3 // 4, "no camera was looked at")
    height, width = seen.shape[:2]
    scale = min(_SIDE_WIDTH / width, _SEEN_HEIGHT / height)
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    colour = seen if seen.ndim == 3 else cv2.cvtColor(seen, cv2.COLOR_GRAY2BGR)
    return np.asarray(cv2.resize(colour, size, interpolation=cv2.INTER_CUBIC), np.uint8)


def _lay(image: Image, part: Image, left: int) -> None:
    """Put a part on the sheet, below the title."""
    height, width = part.shape[:2]
    image[_TOP : _TOP + height, left : left + width] = part


def _blank(width: int, height: int, words: str) -> Image:
    canvas = Canvas(width, height, RULE)
    canvas.text(((width - text_width(words, 15)) / 2, height / 2), words, FADED, 15)
    return canvas.image()


def _draw_legend(canvas: Canvas, top: int, story: Story, colours: dict[str, Colour]) -> None:
    """Draw a line for each state: its colour, when it was reached first, how long it lasted in all."""
    columns = (_SIDE + 84.0, _SIDE + _SIDE_WIDTH - 230.0, _SIDE + _SIDE_WIDTH - 80.0)
    y = top + 44.0
    for x, words in zip(columns, ("state", "reached", "lasted"), strict=True):
        canvas.text((x, y), words, FADED, 13)
    canvas.line([(_SIDE, y + 14), (_SIDE + _SIDE_WIDTH, y + 14)], RULE, 1)
    y += 8
    for state, reached, lasted in story.track.spells():
        y += 36
        if y > HEIGHT - _EDGE:
            break
        canvas.line([(_SIDE + 6, y - 7), (_SIDE + 58, y - 7)], colours[state], 7)
        if state in story.result.milestones:
            overhead.draw_ring(canvas, (_SIDE + 32, y - 7), 11, colours[state])
        for x, words in zip(columns, (state, f"{reached:.1f} s", f"{lasted:.1f} s"), strict=True):
            canvas.text((x, y), words, INK, 15)
