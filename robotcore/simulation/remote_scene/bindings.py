"""Bind each device of a robot to an object of an existing scene, as a section of the robot's file says."""

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
from robotcore.errors import DescriptionError, DeviceError, DeviceGroupError, find_nearest
from robotcore.hal.check_finding import Finding
from robotcore.simulation.remote_scene.devices import choose_intrinsics
from robotcore.simulation.remote_scene.interface import ObjectKind, Scene, SceneObject

Paths = Annotated[
    tuple[Annotated[str, Field(min_length=1)], ...],
    BeforeValidator(lambda paths: (paths,) if isinstance(paths, str) else paths),
    Field(min_length=1, description='a path in quotes, or a list of them: ["/robot/joint", "old_name"]'),
]
"""The possible paths of an object, or its names in old scenes. The first path that exists in the scene is used."""


class ObjectBinding(StrictModel):
    """The scene object of a device.

    >>> ObjectBinding(path="/rover/nose").path
    ('/rover/nose',)
    """

    path: Paths


class JointBinding(ObjectBinding):
    """The joint of a motor or an encoder."""

    reversed: bool = False
    """Whether the joint turns backwards as the robot drives forward."""


class CameraBinding(ObjectBinding):
    """The vision sensor of a camera."""

    as_found: bool = False
    """Whether to use the resolution and the field of view of the scene's vision sensor.

    If False, they must equal those of the robot's description.
    """


class DisplayBinding(ObjectBinding):
    """The vision sensor that shows the pictures of a display."""

    optional: bool = False
    """Whether the scene may lack the object. The display then keeps its pictures in memory."""


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
    """A device and its scene object."""

    description: AnyDevice
    place: ObjectBinding
    """The device's table in the section: the path of the object, and options."""
    kind: ObjectKind
    """The required kind of object."""
    others: frozenset[str] = frozenset()
    """The paths of other devices' objects. Error messages do not suggest these paths."""


def read_bindings(
    robot: RobotDescription, section: str, names: Iterable[str] | None = None
) -> tuple[SceneBinding, ...]:
    """Return the bindings of a robot's devices.

    section: the name of the backend's section in the robot's file.
    names: the devices to bind; None stands for all.

    The result omits displays without an entry, whose pictures stay in memory, and batteries, which no scene has.
    Raises DescriptionError with all mistakes in the section.

    >>> from robotcore.description import load_robot
    >>> [binding.place.path for binding in read_bindings(load_robot("lookout"), "vrep", {"eye"})]
    [('/v0', 'v0')]
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
        remedy = f'Add the scene object of each device: [{section}.{name}] with path = "{path}"'
        raise DescriptionError(robot.source, section, "is missing", remedy)
    bound, faults = read_each(robot, section, needed, _read_binding, partial(_suggest_path, robot))
    if faults:
        raise DescriptionError.of_all(robot.source, faults)
    return tuple(
        replace(each, others=_find_other_paths(each, bound)) for each in bound if each.description.name in chosen
    )


def _find_other_paths(one: SceneBinding, bound: Iterable[SceneBinding]) -> frozenset[str]:
    """Return the paths of all devices that have another object. An encoder has the same object as its motor."""
    paths = set(one.place.path)
    return frozenset().union(*(each.place.path for each in bound if paths.isdisjoint(each.place.path)))


def _suggest_path(robot: RobotDescription, description: AnyDevice) -> str:
    return f'Name its {_BINDINGS[type(description)][1].value} in the scene: path = "/{robot.name}/{description.name}"'


def _read_binding(description: AnyDevice, key: str, table: Any) -> SceneBinding:
    if isinstance(description, BatteryDescription):
        raise MistakesError((key, "is not allowed: a scene has no battery", "Remove it"))
    model, kind = _BINDINGS[type(description)]
    if not isinstance(table, Mapping):
        raise MistakesError((key, f"should be a table, got {table!r}", f"Write [{key}], and its path in the next line"))
    return SceneBinding(description, validate_table(model, key, table), kind)


Found = dict[str, SceneObject | None]
"""The scene objects by device name; None for an optional display that the scene does not have."""


def find_all(robot: str, bound: Sequence[SceneBinding], scene: Scene) -> Found:
    """Return the scene object of each device.

    robot: the robot's name, for the error message.

    Raises DeviceError, or DeviceGroupError if several devices fail.
    """
    found, failures = {}, []
    for each in bound:
        try:
            found[each.description.name] = find(each, scene)
        except DeviceError as failure:  # noqa: PERF203  the error names each device that fails
            failures.append(failure)
    failures += _find_shared_motors(bound, found)
    if len(failures) == 1:
        raise failures[0]
    if failures:
        raise DeviceGroupError(f"opening {robot}", failures)
    return found


def find(bound: SceneBinding, scene: Scene) -> SceneObject | None:
    """Return the scene object of a device: the first of its paths that exists.

    Returns None if an optional display has no object. Raises DeviceError if another device has none, if the object is
    of another kind, if its optics differ from the description, or if its sensor does not work.
    """
    found = next((candidate for path in bound.place.path if (candidate := scene.find(path))), None)
    if found is None:
        if isinstance(bound.place, DisplayBinding) and bound.place.optional:
            return None
        raise _missing_object_error(bound, scene)
    if found.kind is not bound.kind:
        raise DeviceError(
            bound.description.name,
            f"{found.path!r} is a {found.kind.value}, expected a {bound.kind.value}. {_suggest_object(bound, scene)}",
            kind="wrong-object",
            path=found.path,
            found=found.kind.value,
            expected=bound.kind.value,
        )
    _require_fit(bound, found.handle, scene)
    return found


def _require_fit(bound: SceneBinding, handle: int, scene: Scene) -> None:
    if isinstance(bound.description, CameraDescription) and isinstance(bound.place, CameraBinding):
        choose_intrinsics(bound.description, scene.read_optics(handle), as_found=bound.place.as_found)
    if isinstance(bound.description, RangeSensorDescription) and (why := scene.diagnose_sensor(handle)):
        raise DeviceError(bound.description.name, why, kind="sensor-not-simulated")


def _missing_object_error(bound: SceneBinding, scene: Scene) -> DeviceError:
    paths = " or ".join(map(repr, bound.place.path))
    return DeviceError(
        bound.description.name,
        f"the scene has no object {paths}. {_suggest_object(bound, scene)}",
        kind="missing-object",
        paths=bound.place.path,
    )


def _suggest_object(bound: SceneBinding, scene: Scene) -> str:
    """Return the nearest path of the right kind that no other device uses, or else all paths of that kind."""
    paths = [each.path for each in scene.list_objects() if each.kind is bound.kind]
    free = [path for path in paths if path not in bound.others]
    if close := next((close for path in bound.place.path if (close := find_nearest(path, free))), None):
        return f"Did you mean {close!r}?"
    return f"The scene's {bound.kind.value}s: {', '.join(sorted(paths)) or 'none'}"


def _find_shared_motors(bound: Sequence[SceneBinding], found: Found) -> Iterator[DeviceError]:
    """Yield an error for each motor that shares its joint with another motor."""
    owners: dict[int, str] = {}
    for name in (each.description.name for each in bound if isinstance(each.description, MotorDescription)):
        if (joint := found.get(name)) and (other := owners.setdefault(joint.handle, name)) != name:
            yield DeviceError(
                name,
                f"the joint {joint.path!r} belongs to {other} too. Name another joint in the robot's file",
                kind="shared-joint",
                path=joint.path,
                other=other,
            )


def inspect_scene(robot: RobotDescription, section: str, scene: Scene) -> Iterator[Finding]:
    """Yield a finding for each device of the section: its scene object, or the mistake. Nothing starts or moves.

    Raises DescriptionError if the section has a mistake.
    """
    for bound in read_bindings(robot, section):
        yield _find_device(bound, scene)


def _find_device(bound: SceneBinding, scene: Scene) -> Finding:
    name = bound.description.name
    try:
        found = find(bound, scene)
    except DeviceError as failure:
        fault, _, remedy = str(failure).removeprefix(f"{name}: ").partition(". ")
        return Finding.error(name, fault, remedy, kind=failure.kind)
    if found is None:
        paths = " or ".join(map(repr, bound.place.path))
        return Finding.ok(name, f"the scene has no object {paths}: pictures stay in memory", kind="kept-in-memory")
    return Finding.ok(name, f"{found.path}, a {found.kind.value}", kind="object-found")
