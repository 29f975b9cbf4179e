"""The base class of the models of descriptions, and the types of their fields."""

from __future__ import annotations

import colorsys
import math
import re
from collections import Counter
from collections.abc import Iterable
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo

from robotcore.errors import Mistake
from robotcore.text import suggestion

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
"""A mapping from the names of colours to red, green and blue, from 0 to 255 each."""


Number = TypeVar("Number", bound=float)


class StrictModel(BaseModel):
    """The base class of the models of descriptions.

    A model refuses unknown keys and numbers that are not finite. Its instances cannot be changed. Error messages quote
    the ``description`` of a field's type, which is the form of the value in a file. A validator must raise `Mistake`,
    or a ValueError whose text is the problem, a semicolon and a remedy.

    >>> from robotcore.description.types import Metres
    >>> class Tray(StrictModel):
    ...     depth_m: Metres
    >>> Tray(depth_m=0.02)
    Tray(depth_m=0.02)
    >>> try:
    ...     Tray(depth_m=0.02, deepth_m=0.03)
    ... except ValueError as error:
    ...     print(error.errors()[0]["msg"])
    Extra inputs are not permitted
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def freeze(value: Any) -> Any:
    """Return a value from a TOML or JSON file, with all lists in it as tuples.

    >>> freeze({"pins": [1, [2, 3]]})
    {'pins': (1, (2, 3))}
    """
    if isinstance(value, list):
        return tuple(freeze(item) for item in value)
    if isinstance(value, dict):
        return {key: freeze(item) for key, item in value.items()}
    return value


def _to_colour(value: Any) -> Any:
    if isinstance(value, str):
        if value not in COLOURS:
            nearest = suggestion(value, list(COLOURS))
            raise Mistake(f"unknown colour {value[:40]!r}", f"{nearest} Or write [r, g, b]", kind="unknown-colour")
        return COLOURS[value]
    return value


Rgb = tuple[int, int, int]
Byte = Annotated[int, Field(ge=0, le=255)]
Colour = Annotated[
    tuple[Byte, Byte, Byte],
    BeforeValidator(_to_colour),
    Field(description="[red, green, blue] from 0 to 255, or the name of a colour"),
]
"""Red, green and blue, from 0 to 255 each. A file may have a name from `COLOURS` instead."""


def _require_order(limits: tuple[float, float]) -> tuple[float, float]:
    if limits[0] > limits[1]:
        problem = f"the lower end {limits[0]:g} is above the upper end {limits[1]:g}"
        raise Mistake(problem, "Swap them", kind="ends-in-wrong-order")
    return limits


def _require_name(value: str) -> str:
    if not re.fullmatch(r"[a-z][a-z0-9_-]{0,63}", value):
        remedy = "Take a lower-case letter and up to 63 lower-case letters, digits, _ and -"
        raise Mistake(f"{value[:40]!r} is not a valid name", remedy, kind="no-name")
    return value


Ordered = AfterValidator(_require_order)
MIN_METRES, MAX_METRES = 0.001, 100.0

Metres = Annotated[float, Field(ge=MIN_METRES, le=MAX_METRES)]
"""A length in metres, from a millimetre to a hundred metres."""

SensorRange = Annotated[float, Field(ge=1e-4, le=1000)]
"""The shortest or the longest distance that a sensor measures, in metres."""

TURN_RAD = 6.3
"""The greatest angle in a file, in radians: a turn, rounded up."""

MIN_DEGREES = 10.0
"""The least number that is probably an angle in degrees, if a file has it in place of radians."""


def build_turn_mistake(angle: float, key: str = "") -> Mistake:
    """Return the mistake for an angle of more than a turn. If it is at least `MIN_DEGREES`, suggest degrees."""
    remedy = f"Take an angle from {-TURN_RAD} to {TURN_RAD}"
    if abs(angle) >= MIN_DEGREES:
        remedy = f"Did you mean {angle:g} degrees? That is {math.radians(angle):.3g} rad"
    return Mistake(f"{angle:g} rad is more than a turn", remedy, kind="out-of-bounds", key=key)


def _require_turn(angle: float, info: ValidationInfo) -> float:
    # Only files are validated with a context. A heading that a seed draws, and a recording has, may be larger.
    if info.context is not None and abs(angle) > TURN_RAD:
        raise build_turn_mistake(angle)
    return angle


Radians = Annotated[float, Field(ge=-100, le=100), AfterValidator(_require_turn)]
"""An angle in radians. In a file, it is at most a turn in either direction."""

Coordinate = Annotated[float, Field(ge=-100, le=100)]
"""A coordinate in metres."""

Between = Annotated[tuple[Number, Number], Ordered, Field(description="[from, to]")]
"""The lower and the upper end of an interval."""

Name = Annotated[str, AfterValidator(_require_name)]
"""A name of up to 64 lower-case letters, digits, ``_`` and ``-``, beginning with a letter."""


def require_unique(kind: str, names: Iterable[str]) -> None:
    """Raise Mistake if a name occurs twice.

    kind: the plural noun for the named objects in the message, such as ``devices``.
    """
    doubles = [name for name, count in Counter(names).items() if count > 1]
    if doubles:
        raise Mistake(f"two {kind} are named {doubles[0]!r}", "Rename one of them", kind="same-name")


def hue_degrees(colour: tuple[int, int, int]) -> float:
    """Return the hue of a colour in degrees: 0 is red, 120 green, 240 blue.

    colour: red, green and blue, from 0 to 255 each.

    >>> hue_degrees((255, 128, 0))
    30.11764705882353
    """
    red, green, blue = (part / 255 for part in colour)
    return colorsys.rgb_to_hsv(red, green, blue)[0] * 360
