"""The base of all description models, and the types of their fields."""

from __future__ import annotations

import colorsys
import re
from collections import Counter
from collections.abc import Iterable
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field

from robotcore.errors import suggestion

COLOURS: dict[str, tuple[int, int, int]] = {
    "black": (25, 25, 25),
    "white": (235, 235, 235),
    "grey": (150, 150, 150),
    "red": (200, 40, 35),
    "orange": (225, 120, 30),
    "yellow": (225, 205, 50),
    "green": (40, 170, 60),
    "cyan": (40, 180, 190),
    "blue": (40, 80, 200),
    "purple": (120, 60, 170),
    "magenta": (200, 50, 160),
    "brown": (125, 85, 50),
    "sand": (205, 190, 160),
}
"""Colours by name, as red, green, blue in 0 to 255."""


Number = TypeVar("Number", bound=float)


class StrictModel(BaseModel):
    """A part of a description: no unknown keys, no change afterwards, finite numbers.

    A type's ``description``, where it has one, says how it is written in a file; messages about mistakes quote it.
    A validator that refuses raises ValueError with the fault and, after a semicolon, the remedy.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def frozen(value: Any) -> Any:
    """Return a value of a file, TOML or JSON, with its lists as tuples."""
    if isinstance(value, list):
        return tuple(frozen(item) for item in value)
    if isinstance(value, dict):
        return {key: frozen(item) for key, item in value.items()}
    return value


def _colour(value: Any) -> Any:
    if isinstance(value, str):
        if value not in COLOURS:
            nearest = suggestion(value, list(COLOURS))
            raise ValueError(f"unknown colour {value[:40]!r}; {nearest} Or take [r, g, b]")
        return COLOURS[value]
    return value


Rgb = tuple[int, int, int]
Byte = Annotated[int, Field(ge=0, le=255)]
Colour = Annotated[
    tuple[Byte, Byte, Byte],
    BeforeValidator(_colour),
    Field(description="[red, green, blue] from 0 to 255, or the name of a colour"),
]
"""Red, green, blue in 0 to 255; in a file also a name."""


def _ordered(limits: tuple[float, float]) -> tuple[float, float]:
    if limits[0] > limits[1]:
        raise ValueError(f"the lower end {limits[0]:g} is above the upper end {limits[1]:g}; swap them")
    return limits


def _named(value: str) -> str:
    if not re.fullmatch(r"[a-z][a-z0-9_-]{0,63}", value):
        raise ValueError(
            f"{value[:40]!r} is no name; take up to 64 lower-case letters, digits, _ and -, beginning with a letter"
        )
    return value


Ordered = AfterValidator(_ordered)
Metres = Annotated[float, Field(ge=0.001, le=100)]
"""A length of something, from a millimetre to a hundred metres."""

Angle = Annotated[float, Field(ge=-100, le=100)]
"""An angle in radians, at most 100 rad (about 16 turns) either way."""

Coordinate = Annotated[float, Field(ge=-100, le=100)]
"""A coordinate, in metres."""

Between = Annotated[tuple[Number, Number], Ordered, Field(description="[from, to]")]
"""Lower and upper end."""

Name = Annotated[str, AfterValidator(_named)]
"""Lower case, digits, ``_`` and ``-``; begins with a letter; up to 64 characters."""


def require_unique(kind: str, names: Iterable[str]) -> None:
    """Raise ValueError where two things have one name."""
    doubles = [name for name, count in Counter(names).items() if count > 1]
    if doubles:
        raise ValueError(f"two {kind} are named {doubles[0]!r}; give each a name of its own")


def hue_degrees(colour: tuple[int, int, int]) -> float:
    """Return the hue of a colour in degrees: 0 red, 120 green, 240 blue."""
    red, green, blue = (part / 255 for part in colour)
    return colorsys.rgb_to_hsv(red, green, blue)[0] * 360
