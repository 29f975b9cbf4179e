"""Two recorded runs in one picture: both paths in the world, and what they are measured by."""

from __future__ import annotations

from robotcore.hal.devices import Image
from robotcore.recording.comparison import Comparison
from robotcore.recording.comparison.words import rows, titles
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
_COLUMNS = (_SIDE, _SIDE + 176, _SIDE + 420)
_COLUMN_WIDTH = 230
_LINE, _ROW = 22, 16


def draw_comparison(comparison: Comparison) -> Image:
    """Return the sheet: BGR, 1000 x 1600; the world is the first recording's."""
    canvas = Canvas(WIDTH, HEIGHT, PAPER)
    verdict, colour = ("alike", GOOD) if comparison.is_alike else ("differ", BAD)
    canvas.text((_EDGE, 66), "  and  ".join(titles(comparison)), INK, 25, bold=True)
    width = canvas.text((_EDGE, 108), verdict, colour, 17, bold=True)
    if comparison.do_rooms_differ:
        canvas.text((_EDGE + width + 18, 108), "the rooms differ: both paths in the room of the first", FADED, 17)
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
        canvas.text((x + 52, y), _fitted(title, _COLUMN_WIDTH - 52, bold=True), INK, 13, bold=True)
    canvas.line([(_SIDE, y + 14), (WIDTH - _EDGE, y + 14)], RULE, 1)
    y += _LINE + _ROW
    for name, *told in rows(comparison):
        canvas.text((_COLUMNS[0], y), name, FADED, 13)
        cells = [_wrapped(words.replace("–", "-")) for words in told]
        for lines, x in zip(cells, _COLUMNS[1:], strict=True):
            for index, line in enumerate(lines):
                canvas.text((x, y + index * _LINE), line, INK, 13)
        y += max(map(len, cells)) * _LINE + _ROW


def _wrapped(words: str) -> list[str]:
    """Return the words in lines that a column has room for."""
    lines: list[str] = []
    for word in words.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and text_width(longer, 13) <= _COLUMN_WIDTH:
            lines[-1] = longer
        else:
            lines.append(_fitted(word, _COLUMN_WIDTH))
    return lines


def _fitted(words: str, width: float, *, bold: bool = False) -> str:
    """Return as much of a word as there is room for."""
    while text_width(words, 13, bold=bold) > width:
        words = words[:-4] + "..."
    return words
