"""Which of its modes a sensor is to run in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Mode = Mapping[str, Any]
"""As picamera2 tells it: ``size``, ``bit_depth``, ``fps`` at most, and of the sensor ``crop_limits`` (x, y, w, h)."""


def widest(modes: Sequence[Mode], fps: float) -> Mode | None:
    """Return the smallest mode that sees all that the sensor sees, at such a rate or else as fast as it can.

    By itself, libcamera takes the mode that is nearest to the picture's size: a small picture comes from a crop out of
    the middle, with half the field of view.
    """
    usable = [mode for mode in modes if "crop_limits" in mode]
    if not usable:
        return None
    seen = max(_area(mode["crop_limits"][2:]) for mode in usable)
    wide = [mode for mode in usable if _area(mode["crop_limits"][2:]) == seen]
    quick = [mode for mode in wide if mode["fps"] >= fps]
    if not quick:
        return max(wide, key=lambda mode: mode["fps"])
    return min(quick, key=lambda mode: (_area(mode["size"]), -mode["bit_depth"]))


def _area(size: Sequence[int]) -> int:
    width, height = size
    return width * height
