"""A backend's section of a robot's file: which object of somebody's scene each device is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from robotcore.description import (
    AnyDevice,
    BatteryDescription,
    CameraDescription,
    DisplayDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    RobotDescription,
    StrictModel,
)
from robotcore.description.sections import MistakesError, read_each, validate_table
from robotcore.errors import DescriptionError
from robotcore.simulation.remote_scene.port import Kind

Paths = Annotated[
    tuple[Annotated[str, Field(min_length=1)], ...],
    BeforeValidator(lambda told: (told,) if isinstance(told, str) else told),
    Field(min_length=1, description='a path in quotes, or a list of them: ["/robot/joint", "old_name"]'),
]
"""Where an object may be: the first that is there counts. Names of old scenes stand beside paths so."""


class Place(StrictModel):
    """The object that a device is."""

    path: Paths


class JointPlace(Place):
    """A wheel's joint; ``reversed`` where it turns backwards when the robot drives forward."""

    reversed: bool = False


class LensPlace(Place):
    """A camera's vision sensor; ``as_found``: its picture's size and field of view count, not the description's."""

    as_found: bool = False


class ScreenPlace(Place):
    """The vision sensor that shows what a display is shown; where ``optional``, a scene may do without it."""

    optional: bool = False


_PLACES: dict[type[StrictModel], tuple[type[Place], Kind]] = {
    MotorDescription: (JointPlace, Kind.JOINT),
    EncoderDescription: (JointPlace, Kind.JOINT),
    RangeSensorDescription: (Place, Kind.PROXIMITY_SENSOR),
    CameraDescription: (LensPlace, Kind.VISION_SENSOR),
    DisplayDescription: (ScreenPlace, Kind.VISION_SENSOR),
}


_NEEDED = (MotorDescription, EncoderDescription, RangeSensorDescription, CameraDescription)


@dataclass(frozen=True)
class Placed:
    """A device, where it is in the scene, and what kind of object that has to be.

    ``others`` are the paths of other devices.
    """

    told: AnyDevice
    place: Place
    kind: Kind
    others: frozenset[str] = frozenset()


def places(robot: RobotDescription, section: str, names: Iterable[str] | None = None) -> tuple[Placed, ...]:
    """Return where the devices of those names, by default all, are, by a backend's ``section`` of the file.

    A display that the section does not tell of is left out: its pictures are kept in memory. So is a battery, of which
    a scene has none. Raises DescriptionError,
    with all that is wrong.
    """
    chosen = {told.name for told in robot.devices} if names is None else set(names)
    needed = [told.name for told in robot.devices if told.name in chosen and isinstance(told, _NEEDED)]
    if section not in robot.backends and needed:
        name = needed[0]
        path = f"/{robot.name}/{name}"
        remedy = f'Name the object of the scene that each device is: [{section}.{name}] with path = "{path}"'
        raise DescriptionError(robot.source, section, "is missing", remedy)
    placed, faults = read_each(robot, section, needed, _placed, partial(_untold, robot))
    if faults:
        raise DescriptionError.of_all(robot.source, faults)
    return tuple(replace(each, others=_others(each, placed)) for each in placed if each.told.name in chosen)


def _others(one: Placed, placed: Iterable[Placed]) -> frozenset[str]:
    """Return the paths of all devices that are another object: an encoder is the same as its motor."""
    paths = set(one.place.path)
    return frozenset().union(*(each.place.path for each in placed if paths.isdisjoint(each.place.path)))


def _untold(robot: RobotDescription, told: AnyDevice) -> str:
    return f'Name the {_PLACES[type(told)][1].value} that it is: path = "/{robot.name}/{told.name}"'


def _placed(told: AnyDevice, key: str, table: Any) -> Placed:
    if isinstance(told, BatteryDescription):
        raise MistakesError((key, "should not be there: a scene has no battery", "Leave it out"))
    model, kind = _PLACES[type(told)]
    if not isinstance(table, Mapping):
        raise MistakesError((key, f"should be a table, got {table!r}", f"Write [{key}], and its path below"))
    return Placed(told, validate_table(model, key, table), kind)
