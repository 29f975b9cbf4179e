"""A drive whose wheels skid in a turn."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import zip_longest
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from robotcore.description.drive.base import Drive, DriveWheel
from robotcore.description.types import Metres, Name
from robotcore.errors import Mistake
from robotcore.geometry import DifferentialGeometry


def _to_tuple(value: Any) -> Any:
    return (value,) if isinstance(value, str) else value


Names = Annotated[tuple[Name, ...], Field(description="a list of names in quotes, from the front to the rear")]
Encoders = Annotated[
    tuple[Name, ...], BeforeValidator(_to_tuple), Field(description="a name in quotes, or a list of names")
]


class SkidDrive(Drive):
    """A drive with two or more driven wheels on each side, which skid sideways in a turn.

    Each wheel has a motor, or two wheels of a side have one motor, such as two motors on one channel of a board.

    The origin of the robot's frame is on the floor under the middle of the wheels. All wheels of a side turn at the
    same velocity.

    >>> from robotcore.description import load_robot
    >>> drive = load_robot("freenove-4wd").drive
    >>> isinstance(drive, SkidDrive), drive.geometry.track > drive.track_m  # the wheels skid in a turn
    (True, True)
    """

    kind: Literal["skid"]
    left: Names
    """The names of the motors on the left, from the front to the rear."""
    right: Names
    """The names of the motors on the right, from the front to the rear."""
    left_encoder: Encoders = ()
    """The names of encoders on the left. The first is on the wheel of the first motor, and so on."""
    right_encoder: Encoders = ()
    """The names of encoders on the right. The first is on the wheel of the first motor, and so on."""
    wheelbase_m: Metres
    """The distance from the middle of the front wheels to the middle of the rear wheels, in metres."""
    track_factor: Annotated[float, Field(ge=1, le=10, description="the effective track divided by track_m, measured")]
    """The effective track divided by ``track_m``.

    A robot whose wheels skid turns as slowly as one with two wheels that are this much farther apart.
    """

    @model_validator(mode="after")
    def _check_sides(self) -> SkidDrive:
        if len(self.left) != len(self.right) or not self.left:
            problem = f"left names {_count(self.left, 'motor')}, and right {_count(self.right, 'motor')}"
            raise Mistake(problem, "Name the same number on both sides, at least 1", kind="uneven-sides")
        _require_once("motor", (*self.left, *self.right))
        _require_once("encoder", (*self.left_encoder, *self.right_encoder))
        if bool(self.left_encoder) != bool(self.right_encoder):
            problem = "only one side has encoders"
            raise Mistake(problem, "Name encoders on both sides or none", kind="one-encoder")
        for key, encoders in (("left_encoder", self.left_encoder), ("right_encoder", self.right_encoder)):
            if len(encoders) > len(self.left):
                problem = f"{key} names {_count(encoders, 'encoder')}, but the side has {_count(self.left, 'motor')}"
                raise Mistake(problem, "Name at most one encoder a motor", kind="too-many-encoders")
        return self

    @property
    def left_motors(self) -> tuple[str, ...]:
        return self.left

    @property
    def right_motors(self) -> tuple[str, ...]:
        return self.right

    @property
    def left_encoders(self) -> tuple[str, ...]:
        return self.left_encoder

    @property
    def right_encoders(self) -> tuple[str, ...]:
        return self.right_encoder

    @property
    def wheelbase(self) -> float:
        return self.wheelbase_m

    @property
    def geometry(self) -> DifferentialGeometry:
        """The geometry of a robot with two wheels that moves in the same way. Its track is the effective track."""
        return DifferentialGeometry(self.wheel_radius_m, self.track_m * self.track_factor)

    @property
    def wheels(self) -> tuple[DriveWheel, ...]:
        y_m = self.track_m / 2
        left = self._list_side("left", y_m, self.left, self.left_encoder)
        return (*left, *self._list_side("right", -y_m, self.right, self.right_encoder))

    def _list_side(
        self, side: str, y_m: float, motors: tuple[str, ...], encoders: tuple[str, ...]
    ) -> Iterator[DriveWheel]:
        names = motors
        if len(motors) == 1:
            names, motors, encoders = (f"front_{side}", f"rear_{side}"), motors * 2, encoders * 2
        for index, (name, motor, encoder) in enumerate(zip_longest(names, motors, encoders)):
            yield DriveWheel(name, self.wheelbase_m * (0.5 - index / (len(names) - 1)), y_m, motor, encoder)


def _count(names: tuple[str, ...], noun: str) -> str:
    return f"{len(names)} {noun}{'' if len(names) == 1 else 's'}"


def _require_once(kind: str, names: tuple[str, ...]) -> None:
    if doubles := [name for name, count in Counter(names).items() if count > 1]:
        problem = f"the {kind} {doubles[0]!r} is named twice"
        raise Mistake(problem, f"Name one {kind} a wheel", kind=f"same-{kind}")
