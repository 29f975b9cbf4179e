"""The distances on the command line of a calibration. A wrong unit gets a suggestion."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import click

from robotcore.cli.options import Command

UNITS_M = {"m": 1.0, "cm": 0.01, "mm": 0.001}
"""The units that people add to a distance, in metres."""


def find_distance_problem(distance_m: float, least_m: float, most_m: float) -> str:
    """Return the problem of a distance in metres that is outside of its limits; ``""`` for a valid one.

    >>> find_distance_problem(50, 0.3, 20), find_distance_problem(0.5, 0.3, 20)
    ('50 m is too far, and the greatest distance is 20 m. Did you mean 0.5?', '')
    """
    if least_m <= distance_m <= most_m:
        return ""
    if distance_m < least_m:
        return f"{distance_m:g} m is too near, and the least distance is {least_m:g} m"
    centimetres = distance_m * UNITS_M["cm"]
    meant = f". Did you mean {centimetres:g}?" if least_m <= centimetres <= most_m else ""
    return f"{distance_m:g} m is too far, and the greatest distance is {most_m:g} m{meant}"


class DistanceType(click.FloatRange):
    """A click type for a distance in metres.

    least_m, most_m: the limits, in metres.
    """

    name = "distance"

    def __init__(self, least_m: float, most_m: float) -> None:
        super().__init__(least_m, most_m)
        self._limits = least_m, most_m

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        try:
            distance = float(value)
        except ValueError:
            distance = math.nan
        if not math.isfinite(distance):
            found = re.fullmatch(rf"\s*(\d*\.?\d+)\s*({'|'.join(UNITS_M)})\s*", str(value))
            remedy = f"Did you mean {float(found[1]) * UNITS_M[found[2]]:g}?" if found else "Give a number such as 0.5"
            self.fail(f"{value!r} is no number of metres. {remedy}", param, ctx)
        if problem := find_distance_problem(distance, *self._limits):
            self.fail(problem, param, ctx)
        return distance


class DistancesType(DistanceType):
    """A click type for a list of distances in metres, which are separated by commas."""

    name = "distances"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        parts = value.split(",") if isinstance(value, str) else value
        convert = super().convert
        return tuple(convert(part, param, ctx) for part in parts)


def distance_option(most_m: float, default_m: float, text: str) -> Callable[[Command], Command]:
    """Return the option ``--distance`` of a command.

    most_m: the greatest distance, in metres.
    default_m: the distance without the option, in metres.
    text: the help text.
    """
    kind = DistanceType(0.2, most_m)
    return click.option(
        "--distance", "distance_m", metavar="METRES", type=kind, default=default_m, show_default=True, help=text
    )
