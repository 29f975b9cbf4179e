"""Functions that return small worlds for tests."""

from __future__ import annotations

from typing import Any

from robotcore.description import Ball, Box, Floor, Start, Walls, WorldDescription


def box(name: str = "box", **keys: Any) -> Box:
    """Return a box, by default with a base of 0.5 m x 0.5 m."""
    return Box(
        **{
            "name": name,
            "shape": "box",
            "colour": "red",
            "length_m": 0.5,
            "width_m": 0.5,
            "height_m": 0.4,
            **keys,
        }
    )


def ball(name: str = "ball", **keys: Any) -> Ball:
    """Return a green ball of 0.1 m radius in the middle by default."""
    return Ball(**{"name": name, "colour": "green", "radius_m": 0.1, "x_m": 0.0, "y_m": 0.0, **keys})


def room(*things: Box | Ball, **keys: Any) -> WorldDescription:
    """Return a walled room of 4 m x 4 m with the start in its south-west."""
    parts = {
        "name": "room",
        "floor": Floor(length_m=4, width_m=4),
        "walls": Walls(height_m=0.3),
        "start": Start(x_m=-1.5, y_m=-1.5),
        "obstacles": tuple(thing for thing in things if isinstance(thing, Box)),
        "targets": tuple(thing for thing in things if isinstance(thing, Ball)),
    }
    return WorldDescription(**{**parts, **keys})
