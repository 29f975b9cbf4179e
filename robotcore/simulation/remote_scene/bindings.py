"""A backend's section of a robot's file: bind each device to an object of an existing scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
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
from robotcore.errors import DescriptionError, DeviceError, DeviceGroupError, nearest
from robotcore.hal.finding import Finding
from robotcore.simulation.remote_scene.devices import intrinsics_of
from robotcore.simulation.remote_scene.interface import ObjectKind, Scene, SceneObject

Paths = Annotated[
    tuple[Annotated[str, Field(min_length=1)], ...],
    BeforeValidator(lambda description: (description,) if isinstance(description, str) else description),
    Field(min_length=1, description='a path in quotes, or a list of them: ["/robot/joint", "old_name"]'),
]
"""Where an object may be: the first that is there counts. Names of old scenes stand beside paths so."""


class ObjectBinding(StrictModel):
    """The object that a device is."""

    path: Paths


class JointBinding(ObjectBinding):
    """A wheel's joint; ``reversed`` where it turns backwards when the robot drives forward."""

    reversed: bool = False


class CameraBinding(ObjectBinding):
    """A camera's vision sensor; ``as_found``: its picture's size and field of view count, not the description's."""

    as_found: bool = False


class DisplayBinding(ObjectBinding):
    """The vision sensor that shows what a display is shown; where ``optional``, a scene may do without it."""

    optional: bool = False


_BINDINGS: dict[type[StrictModel], tuple[type[ObjectBinding], ObjectKind]] = {
    MotorDescription: (JointBinding, ObjectKind.JOINT),
    EncoderDescription: (JointBinding, ObjectKind.JOINT),
    RangeSensorDescription: (ObjectBinding, ObjectKind.PROXIMITY_SENSOR),
    CameraDescription: (CameraBinding, ObjectKind.VISION_SENSOR),
    DisplayDescription: (DisplayBinding, ObjectKind.VISION_SENSOR),
}


_NEEDED = (MotorDescription, EncoderDescription, RangeSensorDescription, CameraDescription)


@dataclass(frozen=True)
class SceneBinding:
    """A device, where it is in the scene, and what kind of object that has to be.

    ``others`` are the paths of other devices.
    """

    description: AnyDevice
    place: ObjectBinding
    kind: ObjectKind
    others: frozenset[str] = frozenset()


def read_bindings(
    robot: RobotDescription, section: str, names: Iterable[str] | None = None
) -> tuple[SceneBinding, ...]:
    """Return where the devices of those names, by default all, are, by a backend's ``section`` of the file.

    A display that the section does not tell of is left out: its pictures are kept in memory. So is a battery, of which
    a scene has none. Raises DescriptionError,
    with all that is wrong.
    """
    chosen = {description.name for description in robot.devices} if names is None else set(names)
    needed = [
        description.name
        for description in robot.devices
        if description.name in chosen and isinstance(description, _NEEDED)
    ]
    if section not in robot.backends and needed:
        name = needed[0]
        path = f"/{robot.name}/{name}"
        remedy = f'Name the object of the scene that each device is: [{section}.{name}] with path = "{path}"'
        raise DescriptionError(robot.source, section, "is missing", remedy)
    bound, faults = read_each(robot, section, needed, _read_binding, partial(_path_remedy, robot))
    if faults:
        raise DescriptionError.of_all(robot.source, faults)
    return tuple(replace(each, others=_others(each, bound)) for each in bound if each.description.name in chosen)


def _others(one: SceneBinding, bound: Iterable[SceneBinding]) -> frozenset[str]:
    """Return the paths of all devices that are another object: an encoder is the same as its motor."""
    paths = set(one.place.path)
    return frozenset().union(*(each.place.path for each in bound if paths.isdisjoint(each.place.path)))


def _path_remedy(robot: RobotDescription, description: AnyDevice) -> str:
    return f'Name the {_BINDINGS[type(description)][1].value} that it is: path = "/{robot.name}/{description.name}"'


def _read_binding(description: AnyDevice, key: str, table: Any) -> SceneBinding:
    if isinstance(description, BatteryDescription):
        raise MistakesError((key, "should not be there: a scene has no battery", "Leave it out"))
    model, kind = _BINDINGS[type(description)]
    if not isinstance(table, Mapping):
        raise MistakesError((key, f"should be a table, got {table!r}", f"Write [{key}], and its path below"))
    return SceneBinding(description, validate_table(model, key, table), kind)


Found = dict[str, SceneObject | None]
"""By the device's name, the object that it is; None for a display that a scene may do without, and does."""


def find_all(robot: str, bound: Sequence[SceneBinding], scene: Scene) -> Found:
    """Return the object of each device; raises DeviceError or DeviceGroupError with all that is not as it should be."""
    found, failures = {}, []
    for each in bound:
        try:
            found[each.description.name] = find(each, scene)
        except DeviceError as failure:  # noqa: PERF203  every one that fails is to be named
            failures.append(failure)
    failures += _shared_motors(bound, found)
    if len(failures) == 1:
        raise failures[0]
    if failures:
        raise DeviceGroupError(f"opening {robot}", failures)
    return found


def find(bound: SceneBinding, scene: Scene) -> SceneObject | None:
    """Return the object that a device is, at the first of its paths where there is one.

    None where there is none, and the scene may do without; else raises DeviceError, which says what was probably meant.
    Also where the object is of another kind, sees otherwise than described, or is not to be believed.
    """
    there = next((thing for path in bound.place.path if (thing := scene.find(path))), None)
    if there is None:
        if isinstance(bound.place, DisplayBinding) and bound.place.optional:
            return None
        raise DeviceError(bound.description.name, _missing(bound, scene))
    if there.kind is not bound.kind:
        raise DeviceError(
            bound.description.name,
            f"{there.path!r} is a {there.kind.value}, expected a {bound.kind.value}. {_offered(bound, scene)}",
        )
    _require_fit(bound, there.handle, scene)
    return there


def _require_fit(bound: SceneBinding, handle: int, scene: Scene) -> None:
    if isinstance(bound.description, CameraDescription) and isinstance(bound.place, CameraBinding):
        intrinsics_of(bound.description, scene.optics(handle), as_found=bound.place.as_found)
    if isinstance(bound.description, RangeSensorDescription) and (why := scene.why_unreliable(handle)):
        raise DeviceError(bound.description.name, why)


def _missing(bound: SceneBinding, scene: Scene) -> str:
    paths = " or ".join(map(repr, bound.place.path))
    return f"the scene has no object {paths}. {_offered(bound, scene)}"


def _offered(bound: SceneBinding, scene: Scene) -> str:
    """Say which object of the right kind, and no other device's, was probably meant, or name them all."""
    paths = [thing.path for thing in scene.objects() if thing.kind is bound.kind]
    free = [path for path in paths if path not in bound.others]
    if close := next((close for path in bound.place.path if (close := nearest(path, free))), None):
        return f"Did you mean {close!r}?"
    return f"The scene's {bound.kind.value}s: {', '.join(sorted(paths)) or 'none'}"


def _shared_motors(bound: Sequence[SceneBinding], found: Found) -> Iterator[DeviceError]:
    """Yield an error for each motor whose joint is another motor's."""
    taken: dict[int, str] = {}
    for name in (each.description.name for each in bound if isinstance(each.description, MotorDescription)):
        if (thing := found.get(name)) and (other := taken.setdefault(thing.handle, name)) != name:
            yield DeviceError(name, f"its joint {thing.path!r} is {other}'s too; name its own one in the file")


def inspect_scene(robot: RobotDescription, section: str, scene: Scene) -> Iterator[Finding]:
    """Yield for each device of the ``section`` the object that it is, or what is wrong; nothing is started or moved.

    Raises DescriptionError where the section is wrong.
    """
    for bound in read_bindings(robot, section):
        yield _find_device(bound, scene)


def _find_device(bound: SceneBinding, scene: Scene) -> Finding:
    name = bound.description.name
    try:
        thing = find(bound, scene)
    except DeviceError as failure:
        fault, _, remedy = str(failure).removeprefix(f"{name}: ").partition(". ")
        return Finding.error(name, fault, remedy)
    if thing is None:
        return Finding.ok(name, f"none of {', '.join(map(repr, bound.place.path))} is there: kept in memory")
    return Finding.ok(name, f"{thing.path}, a {thing.kind.value}")
