"""The colours of the pictures, as red, green, blue."""

from __future__ import annotations

from collections.abc import Iterable

from robotcore.view.canvas import Colour

PAPER: Colour = (252, 252, 250)
INK: Colour = (33, 37, 46)
FADED: Colour = (118, 124, 135)
RULE: Colour = (222, 224, 228)
GOOD: Colour = (30, 132, 73)
FAIR: Colour = (190, 120, 20)
BAD: Colour = (190, 45, 40)

_STATES: tuple[Colour, ...] = (
    (36, 99, 235),
    (235, 94, 20),
    (168, 30, 175),
    (5, 145, 178),
    (220, 38, 90),
    (30, 27, 110),
    (130, 70, 10),
    (85, 88, 100),
)
"""Far apart, for the common kinds of colour blindness too, and none of them like a green ball."""


def state_colours(states: Iterable[str]) -> dict[str, Colour]:
    """Return a colour for each state; they begin anew where there are more states than colours."""
    return {state: _STATES[index % len(_STATES)] for index, state in enumerate(states)}


def darker(colour: Colour, share: float) -> Colour:
    """Return a colour with ``share`` of its light."""
    red, green, blue = colour
    return round(red * share), round(green * share), round(blue * share)


def lighter(colour: Colour, share: float) -> Colour:
    """Return a colour ``share`` of the way to white."""
    red, green, blue = (round(part + (255 - part) * share) for part in colour)
    return red, green, blue
