"""A canvas to draw on, the colours of the pictures, and their PNG files.

Coordinates are pixels, and colours are (red, green, blue). The canvas is drawn at twice its size and then scaled down,
so that edges are smooth.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Iterable, Sequence
from hashlib import sha256

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.optics import Image
from robotcore.text import escape

Colour = tuple[int, int, int]
Point = tuple[float, float]

SUPERSAMPLING = 2
"""Each side of the canvas has this many pixels per pixel of the final picture."""

MAX_PICTURE_SIDE = 8192
"""The greatest number of pixels along a side of a picture that is drawn. OpenCV 4 maps at most 32766."""

_SHIFT = 4
"""OpenCV receives coordinates as integers with this many fractional bits. Their unit is 1/16 pixel."""


class Canvas:
    """A picture to draw on, ``width`` x ``height`` pixels, with the origin at the top left.

    >>> canvas = Canvas(64, 48, PAPER)
    >>> canvas.fill_circle((32, 24), 10, BAD)
    >>> canvas.render().shape
    (48, 64, 3)
    >>> [int(part) for part in canvas.render()[24, 32, ::-1]]
    [190, 45, 40]
    """

    def __init__(self, width: int, height: int, colour: Colour) -> None:
        self.width, self.height = width, height
        self._sheet: Image = np.empty((height * SUPERSAMPLING, width * SUPERSAMPLING, 3), np.uint8)
        self._sheet[:] = colour[::-1]

    def render(self) -> Image:
        """Return the final picture, BGR, of shape (height, width, 3)."""
        small = cv2.resize(self._sheet, (self.width, self.height), interpolation=cv2.INTER_AREA)
        return np.asarray(small, np.uint8)

    def fill_polygon(self, corners: Sequence[Point], colour: Colour) -> None:
        cv2.fillPoly(self._sheet, [_to_fixed_point(corners)], colour[::-1], cv2.LINE_AA, _SHIFT)

    def draw_line(self, points: Sequence[Point], colour: Colour, width: float, *, closed: bool = False) -> None:
        """Draw a line through points, with round corners and ends."""
        thickness = max(1, round(width * SUPERSAMPLING))
        cv2.polylines(self._sheet, [_to_fixed_point(points)], closed, colour[::-1], thickness, cv2.LINE_AA, _SHIFT)

    def fill_circle(self, centre: Point, radius: float, colour: Colour) -> None:
        x, y = _to_fixed_point([centre])[0]
        reach = round(radius * SUPERSAMPLING * 2**_SHIFT)
        cv2.circle(self._sheet, (int(x), int(y)), reach, colour[::-1], cv2.FILLED, cv2.LINE_AA, _SHIFT)

    def draw_picture(self, image: Image, top_left: Point, bottom_right: Point) -> None:
        """Draw a BGR picture into a rectangle. The parts of the rectangle beyond the canvas are left out."""
        corners = np.array((top_left, bottom_right)) * SUPERSAMPLING
        size = corners[1] - corners[0]
        most = np.minimum(image.shape[1::-1], MAX_PICTURE_SIDE)
        shrunk = np.clip(np.rint(size), 1, most).astype(int).tolist()
        small = cv2.resize(image, shrunk, interpolation=cv2.INTER_AREA)
        scales = size / shrunk
        matrix = np.column_stack((np.diag(scales), corners[0] + (scales - 1) / 2))
        whole = self._sheet.shape[1::-1]
        cv2.warpAffine(small, matrix, whole, self._sheet, cv2.INTER_NEAREST, cv2.BORDER_TRANSPARENT)

    def draw_shadow(self, shapes: Iterable[Sequence[Point]], opacity: float, softness: float) -> None:
        """Darken the inside of polygons. Their edges are blurred by ``softness`` pixels."""
        mask = cv2.GaussianBlur(self._mask(shapes), (0, 0), softness * SUPERSAMPLING)
        self._blend(np.asarray(mask, np.uint8), (20, 22, 30), opacity)

    def write_text(self, place: Point, words: str, colour: Colour, height: float, *, bold: bool = False) -> float:
        """Write a text on the canvas, and return the text's width in pixels.

        place: the left end of the baseline.
        words: the text. A control character or a lone surrogate is written as an escape.
        height: the height of capital letters, in pixels.
        """
        scale, thickness = _compute_font_size(height, bold=bold)
        at = (round(place[0] * SUPERSAMPLING), round(place[1] * SUPERSAMPLING))
        cv2.putText(self._sheet, escape(words), at, _FACE, scale, colour[::-1], thickness, cv2.LINE_AA)
        return measure_text(words, height, bold=bold)

    def _mask(self, shapes: Iterable[Sequence[Point]]) -> NDArray[np.uint8]:
        mask = np.zeros(self._sheet.shape[:2], np.uint8)
        for corners in shapes:
            cv2.fillPoly(mask, [_to_fixed_point(corners)], 255, cv2.LINE_AA, _SHIFT)
        return mask

    def _blend(self, mask: NDArray[np.uint8], colour: Colour, opacity: float) -> None:
        x, y, width, height = cv2.boundingRect(mask)
        area = self._sheet[y : y + height, x : x + width]
        share = mask[y : y + height, x : x + width, None] * np.float32(opacity / 255)
        area[:] = area + (np.array(colour[::-1], np.float32) - area) * share


def encode_png(image: Image) -> bytes:
    """Return a picture as PNG."""
    _, png = cv2.imencode(".png", image)
    return png.tobytes()


_FACE = cv2.FONT_HERSHEY_SIMPLEX
_CAPITAL_PX = 21
"""The height of a capital letter of this font at scale 1, in pixels."""

_HAS_OUTLINES = int(cv2.__version__.partition(".")[0]) >= 5
"""Whether OpenCV draws filled letters, whose thickness is 1, or 2 for bold. Before version 5 it draws them as lines."""


def measure_text(words: str, height: float, *, bold: bool = False) -> float:
    """Return the width of a text, in pixels. ``height`` is the height of its capital letters."""
    (width, _), _ = cv2.getTextSize(escape(words), _FACE, *_compute_font_size(height, bold=bold))
    return float(width) / SUPERSAMPLING


def shorten_text(words: str, width: float, height: float, *, bold: bool = False) -> str:
    """Return a text that is at most ``width`` pixels wide. In a longer text, ``...`` replaces the middle."""
    if measure_text(words, height, bold=bold) <= width:
        return words
    fits = bisect(range(len(words)), width, key=lambda kept: measure_text(_cut_middle(words, kept), height, bold=bold))
    return _cut_middle(words, max(0, fits - 1))


def _cut_middle(words: str, kept: int) -> str:
    return words[: kept - kept // 2] + "..." + words[len(words) - kept // 2 :]


def _compute_font_size(height: float, *, bold: bool) -> tuple[float, int]:
    fine = height * SUPERSAMPLING
    stroke = max(1, round(fine / (10 if bold else 14)))
    return fine / _CAPITAL_PX, 1 + bold if _HAS_OUTLINES else stroke


def _to_fixed_point(points: Sequence[Point]) -> NDArray[np.int32]:
    """Return points as integers in 1/16 pixel of the canvas, of shape (n, 2)."""
    fine = (np.asarray(points, float) * SUPERSAMPLING - 0.5) * 2**_SHIFT
    return np.asarray(np.rint(fine), np.int32)


PAPER: Colour = (252, 252, 250)
INK: Colour = (33, 37, 46)
FADED: Colour = (118, 124, 135)
RULE: Colour = (222, 224, 228)
GOOD: Colour = (30, 132, 73)
FAIR: Colour = (190, 120, 20)
BAD: Colour = (190, 45, 40)

SERIES: tuple[Colour, ...] = (
    (36, 99, 235),
    (235, 94, 20),
    (168, 30, 175),
    (5, 145, 178),
    (220, 38, 90),
    (30, 27, 110),
    (130, 70, 10),
    (85, 88, 100),
)
"""Colours for things that are shown together, without green.

They are distinct for people with the common kinds of colour blindness.
"""

_SALT = b"73"
"""The bytes before a state's name in its digest. With them, the states of each app of robotcore have own colours."""


def choose_state_colours(states: Iterable[str]) -> dict[str, Colour]:
    """Return a colour for each state. A state's name decides its colour, so it is the same in every picture.

    If states of a picture have the same colour by their names, one of them keeps it, and the others get free colours.
    The colours repeat if there are more than eight states.
    """
    names = sorted(set(states))
    chosen: dict[str, Colour] = {}
    for name in names:
        digest = sha256(_SALT + name.encode(errors="replace")).digest()
        if (colour := SERIES[digest[0] % len(SERIES)]) not in chosen.values():
            chosen[name] = colour
    free = [colour for colour in SERIES if colour not in chosen.values()] or SERIES
    rest = (name for name in names if name not in chosen)
    return {**chosen, **{name: free[index % len(free)] for index, name in enumerate(rest)}}


def darken(colour: Colour, share: float) -> Colour:
    """Return a colour with each component multiplied by ``share``, from 0 to 1."""
    red, green, blue = colour
    return round(red * share), round(green * share), round(blue * share)


def lighten(colour: Colour, share: float) -> Colour:
    """Return a mixture of a colour and white. ``share`` is the share of white, from 0 to 1."""
    red, green, blue = (round(part + (255 - part) * share) for part in colour)
    return red, green, blue
