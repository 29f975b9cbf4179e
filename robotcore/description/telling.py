"""What a run is under, by name: where to look when it fails."""

from __future__ import annotations

from robotcore.description.conditions import Conditions
from robotcore.description.light import Light
from robotcore.description.randomising import Told


def light_told(light: Light) -> Told:
    """Return by name what a seed draws of the light with every layout."""
    return {f"light_{name}": getattr(light, name) for name in ("azimuth_rad", "elevation_rad", "brightness")}


def conditions_told(conditions: Conditions) -> Told:
    """Return by name the conditions that are not perfect."""
    told: Told = conditions.model_dump(exclude_defaults=True)
    return told


def picture_told(drawn: Told) -> Told:
    """Return ``picture_brightness``, the light's times the camera's exposure, where both are among what was drawn.

    Pictures that a dim lamp and a short exposure make dark together have neither of the two in common.
    """
    light, exposure = drawn.get("light_brightness"), drawn.get("camera_exposure")
    if isinstance(light, float) and isinstance(exposure, float):
        return {"picture_brightness": round(light * exposure, 4)}
    return {}
