"""What a built robot sees with: vision sensors, for cameras, displays and a range sensor's fan."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drivers.coppeliasim.placing import Placement
from drivers.coppeliasim.workshop import Workshop

NEAR_M, FAR_M = 0.01, 40.0
_EXPLICIT, _PERSPECTIVE, _OWN_BACKGROUND = 1, 2, 128


@dataclass(frozen=True)
class Eye:
    """A vision sensor that is to be: ``size`` in pixels, a horizontal field of view, what is near and far in metres.

    ``empty`` is the grey, from 0 to 1, where nothing is, and ``seen`` the collection that it sees; -1 is all there is.
    What is ``ignored``, ``"depth"`` or ``"rgb"``, is not rendered.
    """

    size: tuple[int, int]
    fov: float
    near_m: float = NEAR_M
    far_m: float = FAR_M
    empty: float = 0.0
    seen: int = -1
    ignored: str = ""


def add_eye(workshop: Workshop, eye: Eye, alias: str, place: Placement, parent: int) -> int:
    """Make a vision sensor that renders when it is told to."""
    floats = [eye.near_m, eye.far_m, longest(eye.fov, *eye.size), 0.02, 0, 0, *[eye.empty] * 3, 0, 0]
    options = _EXPLICIT | _PERSPECTIVE | _OWN_BACKGROUND
    sensor = workshop.make("createVisionSensor", options, [*eye.size, 0, 0], floats)
    workshop.set_int(sensor, "visionintparam_entity_to_render", eye.seen)
    if eye.ignored:
        workshop.set_int(sensor, f"visionintparam_{eye.ignored}ignored", 1)
    workshop.put(sensor, place, alias, parent)
    return sensor


def longest(fov: float, width: int, height: int) -> float:
    """Return the perspective angle, which is that of a picture's longer side, for a horizontal field of view."""
    return fov if width >= height else 2 * math.atan(math.tan(fov / 2) * height / width)


def across(angle: float, width: int, height: int) -> float:
    """Return the horizontal field of view for a perspective angle."""
    return angle if width >= height else 2 * math.atan(math.tan(angle / 2) * width / height)
