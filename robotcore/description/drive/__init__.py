"""The drives of robots: two wheels, wheels that skid, and wheels that steer.

A run commands each of them by the velocities of a left and a right wheel on one axle, with the geometry of
`Drive.geometry`. The wheels of a drive that skids or steers are the wheels of a robot with a differential drive that
moves in the same way.
"""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from pydantic import BeforeValidator, Field

from robotcore.description.drive.ackermann import AckermannDrive as AckermannDrive
from robotcore.description.drive.base import Caster as Caster
from robotcore.description.drive.base import Drive as Drive
from robotcore.description.drive.base import DriveWheel as DriveWheel
from robotcore.description.drive.base import Mass as Mass
from robotcore.description.drive.skid import SkidDrive as SkidDrive
from robotcore.description.drive.two_wheel import TwoWheelDrive as TwoWheelDrive
from robotcore.errors import Mistake

DIFFERENTIAL = "differential"
"""The kind of a drive without the key ``kind``."""


def _add_kind(value: Any) -> Any:
    if not isinstance(value, dict) or "kind" in value:
        return value
    if "wheelbase_m" in value:
        raise Mistake("has wheelbase_m, but no kind", 'Add kind = "skid" or kind = "ackermann"', kind="missing-tag")
    return {"kind": DIFFERENTIAL, **value}


AnyDrive: TypeAlias = Annotated[TwoWheelDrive | SkidDrive | AckermannDrive, Field(discriminator="kind")]
OptionalDrive: TypeAlias = Annotated[AnyDrive | None, BeforeValidator(_add_kind)]
"""A drive of any kind, or None. Without the key ``kind``, it is a differential drive."""
