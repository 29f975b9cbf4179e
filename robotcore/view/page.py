"""The page of a picture: its size, its title, the places of its parts, and its PNG file."""

from __future__ import annotations

from pathlib import Path

from robotcore import files
from robotcore.canvas import FADED, INK, PAPER, Canvas, Colour, shorten_text
from robotcore.optics import Image

WIDTH, HEIGHT = 1600, 1000
EDGE, TOP = 44, 136
"""The margin of the page, and the height of its title, in pixels."""
MAP = HEIGHT - TOP - EDGE
"""The width and the height of the map, in pixels."""
SIDE = EDGE + MAP + 40
"""The left end of the column beside the map, in pixels."""
SIDE_WIDTH = WIDTH - EDGE - SIDE

_TITLE_WIDTH = WIDTH - 2 * EDGE
_TITLE_PX, _SUBTITLE_PX = 25, 17


def begin_page(heading: str, verdict: str, colour: Colour, words: str) -> Canvas:
    """Return a page with a title: a heading, and below it a verdict in its colour and other words.

    A text that is longer than the page is wide is shortened.
    """
    canvas = Canvas(WIDTH, HEIGHT, PAPER)
    heading = shorten_text(heading, _TITLE_WIDTH, _TITLE_PX, bold=True)
    canvas.write_text((EDGE, 66), heading, INK, _TITLE_PX, bold=True)
    used = canvas.write_text((EDGE, 108), verdict, colour, _SUBTITLE_PX, bold=True) + 18
    canvas.write_text((EDGE + used, 108), shorten_text(words, _TITLE_WIDTH - used, _SUBTITLE_PX), FADED, _SUBTITLE_PX)
    return canvas


def join_titles(*titles: str) -> str:
    """Return the heading of a page about several files. A long title is shortened, so that each is on the page."""
    joint = "  and  "
    width = (_TITLE_WIDTH - 160 * (len(titles) - 1)) / len(titles)
    return joint.join(shorten_text(title, width, _TITLE_PX, bold=True) for title in titles)


def finish_page(canvas: Canvas, world_map: Image, side_picture: Image | None = None) -> Image:
    """Return the picture of a page with its map, and with another picture beside the map."""
    page = canvas.render()
    for part, left in ((world_map, EDGE), (side_picture, SIDE)):
        if part is not None:
            height, width = part.shape[:2]
            page[TOP : TOP + height, left : left + width] = part
    return page


OPTION = "--picture"
"""The option of the command line that names the file of a picture."""


def save_png(content: bytes, file: Path, option: str = OPTION) -> None:
    """Replace a file by a PNG. If the PNG cannot be written, keep the old file and raise UsageError.

    option: the option of the command line that names the file; ``""`` if a call names it.
    """
    files.save_output(content, file, option)


def require_writable(file: Path, option: str = OPTION) -> None:
    """Raise UsageError if a file's suffix is not .png or it cannot be replaced. The check does not change the file.

    option: as for `save_png`.
    """
    files.require_writable(file, option, ".png")
