"""The page's colours: those of the run pictures, and lighter ones for a dark page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from robotcore.view.canvas import Colour, lighter, state_colours

_FOR_DARK = 0.42
"""How far a colour goes to white on a dark page."""


class Shades(NamedTuple):
    """One colour as CSS, on a light page and on a dark one."""

    light: str
    dark: str


def shades_of(names: Sequence[str]) -> list[Shades]:
    """Return a colour for each name, far apart for the colour-blind too."""
    return [Shades(_css(colour), _css(lighter(colour, _FOR_DARK))) for colour in state_colours(names).values()]


def _css(colour: Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)
