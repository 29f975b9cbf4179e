"""What is painted on, with what, and what paints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Canvas = NDArray[np.uint32]
"""Height x width; a pixel is an ink: blue, green, red and a spare byte in memory, or a thing's number."""


class Palette(NamedTuple):
    """The inks of everything: of each face by its number, of each ball by its part, from edge-on to the lamp."""

    sky: int
    ground: int
    faces: Sequence[int]
    balls: Mapping[int, NDArray[np.uint32]]


class Stroke(Protocol):
    """A face or a ball in a picture; ``columns`` are the first and the last that it may touch.

    ``part`` is whose it is: blocks are numbered first, then balls.
    """

    @property
    def part(self) -> int: ...
    @property
    def columns(self) -> tuple[float, float]: ...
    def paint(self, canvas: Canvas, palette: Palette) -> None: ...
