"""Two recorded runs in one picture: both paths in the world, and what they are measured by."""

from __future__ import annotations

from robotcore.comparison import Comparison
from robotcore.comparison.words import rows, titles
from robotcore.devices import Image
from robotcore.view import overhead
from robotcore.view.canvas import Canvas, Colour, text_width
from robotcore.view.palette import BAD, FADED, GOOD, INK, PAPER, RULE
from robotcore.view.recorded import story_of, world_of
from robotcore.view.track import Track

WIDTH, HEIGHT = 1600, 1000
FIRST: Colour = (36, 99, 235)
SECOND: Colour = (235, 94, 20)
_EDGE, _GAP, _TOP = 44, 40, 136
_MAP = HEIGHT - _TOP - _EDGE
_SIDE = _EDGE + _MAP + _GAP
_COLUMNS = (_SIDE, _SIDE + 180, _SIDE + 400)


def draw_comparison(comparison: Comparison) -> Image:
    """Return the sheet: BGR, 1000 x 1600; the world is the first recording's."""
    canvas = Canvas(WIDTH, HEIGHT, PAPER)
    verdict, colour = ("alike", GOOD) if comparison.is_alike else ("differ", BAD)
    canvas.text((_EDGE, 66), "  and  ".join(titles(comparison)), INK, 25, bold=True)
    canvas.text((_EDGE, 108), verdict, colour, 17, bold=True)
    _draw_table(canvas, comparison)
    image = canvas.image()
    image[_TOP : _TOP + _MAP, _EDGE : _EDGE + _MAP] = _map(comparison)
    return image


def _map(comparison: Comparison) -> Image:
    canvas = Canvas(_MAP, _MAP, PAPER)
    stories = [story_of(side.recording) for side in (comparison.first, comparison.second)]
    both = Track()
    both.steps = [step for story in stories for step in story.track.steps]
    world = world_of(comparison.first.recording, both)
    chart = overhead.Chart.fitting(world, both, _MAP)
    overhead.draw_world(canvas, chart, world)
    for story, colour in zip(stories, (FIRST, SECOND), strict=True):
        if steps := story.track.steps:
            overhead.draw_start(canvas, chart, story.robot, steps[0].pose)
            overhead.draw_track(canvas, chart, story.track, dict.fromkeys(story.track.states, colour))
            overhead.draw_robot(canvas, chart, story.robot, steps[-1].pose)
            places = story.track.places(story.result.milestones)
            overhead.draw_milestones(canvas, chart, places, dict.fromkeys(places, colour))
    return canvas.image()


def _draw_table(canvas: Canvas, comparison: Comparison) -> None:
    y = _TOP + 20.0
    for title, colour, x in zip(titles(comparison), (FIRST, SECOND), _COLUMNS[1:], strict=True):
        canvas.line([(x, y - 6), (x + 40, y - 6)], colour, 7)
        canvas.text((x + 52, y), _fitted(title, 150), INK, 13, bold=True)
    canvas.line([(_SIDE, y + 14), (WIDTH - _EDGE, y + 14)], RULE, 1)
    for name, *told in rows(comparison):
        y += 40
        canvas.text((_COLUMNS[0], y), name, FADED, 13)
        for words, x in zip(told, _COLUMNS[1:], strict=True):
            canvas.text((x, y), _fitted(words.replace("–", "-"), 210), INK, 13)


def _fitted(words: str, width: float) -> str:
    """Return as many of the words as there is room for."""
    while text_width(words, 13) > width:
        words = words[:-4] + "..."
    return words
