"""What a robot's file may say of any camera."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from robotcore.description import Described

Seconds = Annotated[float, Field(gt=0, le=1)]


class CameraSettings(Described):
    """How a camera is mounted, and how its exposure and its white balance are found.

    With ``lock``, both are held as soon as they have settled, after ``settle_s`` at the latest: a colour that drifts is
    the most common reason why a real robot does not see what it looks for. ``exposure_s`` is set by hand.
    """

    fps: Annotated[float, Field(ge=1, le=240)] = 30.0
    lock: bool = True
    settle_s: Annotated[float, Field(gt=0, le=30)] = 2.0
    exposure_s: Seconds | None = None
    rotate_180: bool = False
    flip_horizontal: bool = False
    flip_vertical: bool = False
