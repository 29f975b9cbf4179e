"""Bind the devices of a robot to objects of an existing scene. A section of the robot's file names the objects."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from robotcore.description import DeviceDescription, RobotDescription
from robotcore.description.sections import read_each, validate_table
from robotcore.errors import DescriptionError, DeviceError, DeviceGroupError, Mistake
from robotcore.hal.check_finding import Finding
from robotcore.hal.kind import load_kind
from robotcore.kinds.camera import CameraDescription
from robotcore.kinds.motor import Motor
from robotcore.simulation.remote_scene.devices import choose_intrinsics
from robotcore.simulation.remote_scene.interface import ObjectKind, Scene, SceneObject
from robotcore.simulation.remote_scene.scene_kinds import (
    BINDINGS,
    REMEDY,
    CameraBinding,
    DisplayBinding,
    ObjectBinding,
    describe_lack,
    find_missing_kinds,
)
from robotcore.text import find_nearest


@dataclass(frozen=True)
class SceneBinding:
    """A device, and its table in a section of the robot's file."""

    description: DeviceDescription
    settings: ObjectBinding
    """The device's table: the path of the scene object, and options."""
    kind: ObjectKind
    """The kind that the scene object must have."""
    other_paths: frozenset[str] = frozenset()
    """The paths of the other devices' scene objects. Error messages do not suggest these paths."""


def read_bindings(
    robot: RobotDescription, section: str, names: Iterable[str] | None = None
) -> tuple[SceneBinding, ...]:
    """Read a section of the robot's file, and return the bindings of the robot's devices.

    section: the name of the section, which is the name of the backend.
    names: the names of the devices to bind; None stands for all.

    The result omits devices of kinds that no scene has, such as a battery. It also omits optional devices, such as a
    display, that the section does not name. Raises DescriptionError with all mistakes in the section.

    >>> from robotcore.description import load_robot
    >>> [binding.settings.path for binding in read_bindings(load_robot("lookout"), "vrep", {"eye"})]
    [('/v0', 'v0')]
    """
    chosen = {description.name for description in robot.devices} if names is None else set(names)
    needed = [
        description.name
        for description in robot.devices
        if description.name in chosen and description.kind in BINDINGS and not load_kind(description.kind).is_optional
    ]
    if section not in robot.backends and needed:
        name = needed[0]
        path = f"/{robot.name}/{name}"
        remedy = f'Add the scene object of each device: [{section}.{name}] with path = "{path}"'
        raise DescriptionError(robot.source, section, "is missing", remedy)
    bound, mistakes = read_each(robot, section, needed, partial(_read_binding, section), partial(_suggest_path, robot))
    if mistakes:
        raise DescriptionError.of_all(robot.source, mistakes)
    return tuple(
        replace(each, other_paths=_find_other_paths(each, bound)) for each in bound if each.description.name in chosen
    )


def _find_other_paths(binding: SceneBinding, bound: Iterable[SceneBinding]) -> frozenset[str]:
    paths = set(binding.settings.path)  # an encoder has the paths of its motor
    return frozenset().union(*(each.settings.path for each in bound if paths.isdisjoint(each.settings.path)))


def _suggest_path(robot: RobotDescription, description: DeviceDescription) -> str:
    return f'Name its {BINDINGS[description.kind][1].value} in the scene: path = "/{robot.name}/{description.name}"'


def _read_binding(section: str, description: DeviceDescription, table: Any) -> SceneBinding:
    if description.kind not in BINDINGS:
        raise Mistake(f"is not allowed: {describe_lack(description)}", "Remove it")
    model, kind = BINDINGS[description.kind]
    if not isinstance(table, Mapping):
        remedy = f"Write [{section}.{description.name}], and its path in the next line"
        raise Mistake(f"should be a table, got {table!r}", remedy)
    return SceneBinding(description, validate_table(model, table), kind)


ObjectsByDevice = dict[str, SceneObject | None]
"""The scene object of each device, by the name of the device; None for a display without a scene object."""


def find_all(robot: str, bound: Sequence[SceneBinding], scene: Scene) -> ObjectsByDevice:
    """Find the scene object of each device.

    robot: the name of the robot, for the error message.
    bound: the bindings of the devices.

    Raises DeviceError if a device has no suitable object (see `find`), or if two motors have the same joint. Raises
    DeviceGroupError if several devices fail.
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
    """Find the scene object of a device. If several of its paths exist in the scene, the first one is used.

    Returns None for an optional display without a scene object. Raises DeviceError

    - if the scene has no object for another device,
    - if the object has the wrong kind,
    - if a vision sensor has other optics than the robot's camera, or
    - if a proximity sensor does not work.
    """
    found = next((candidate for path in bound.settings.path if (candidate := scene.find(path))), None)
    if found is None:
        if isinstance(bound.settings, DisplayBinding) and bound.settings.optional:
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
    if isinstance(bound.description, CameraDescription) and isinstance(bound.settings, CameraBinding):
        choose_intrinsics(bound.description, scene.read_optics(handle), as_found=bound.settings.as_found)
    if bound.kind is ObjectKind.PROXIMITY_SENSOR and (why := scene.diagnose_sensor(handle)):
        raise DeviceError(bound.description.name, why, kind="sensor-not-simulated")


def _missing_object_error(bound: SceneBinding, scene: Scene) -> DeviceError:
    paths = " or ".join(map(repr, bound.settings.path))
    return DeviceError(
        bound.description.name,
        f"the scene has no object {paths}. {_suggest_object(bound, scene)}",
        kind="missing-object",
        paths=bound.settings.path,
    )


def _suggest_object(bound: SceneBinding, scene: Scene) -> str:
    """Suggest the path that is most similar to the device's path. If no path is similar, list all paths."""
    paths = [each.path for each in scene.list_objects() if each.kind is bound.kind]
    free = [path for path in paths if path not in bound.other_paths]
    if close := next((close for path in bound.settings.path if (close := find_nearest(path, free))), None):
        return f"Did you mean {close!r}?"
    return f"The scene's {bound.kind.value}s: {', '.join(sorted(paths)) or 'none'}"


def _find_shared_motors(bound: Sequence[SceneBinding], found: ObjectsByDevice) -> Iterator[DeviceError]:
    first_motors: dict[int, str] = {}
    for name in (each.description.name for each in bound if each.description.kind == Motor.kind):
        if (joint := found.get(name)) and (other := first_motors.setdefault(joint.handle, name)) != name:
            yield DeviceError(
                name,
                f"the joint {joint.path!r} is the joint of {other} too. Name another joint in the robot's file",
                kind="shared-joint",
                path=joint.path,
                other=other,
            )


def inspect_scene(robot: RobotDescription, section: str, scene: Scene) -> Iterator[Finding]:
    """Yield a finding for each device: its scene object, or the reason why it has none. No motor turns.

    section: the name of the section of the robot's file.

    Raises DescriptionError if the section has a mistake.
    """
    for bound in read_bindings(robot, section):
        yield _find_device(bound, scene)
    for device in find_missing_kinds(robot):
        yield Finding.warning(device.name, describe_lack(device), REMEDY, kind="not-in-scene")


def _find_device(bound: SceneBinding, scene: Scene) -> Finding:
    name = bound.description.name
    try:
        found = find(bound, scene)
    except DeviceError as failure:
        problem, _, remedy = str(failure).removeprefix(f"{name}: ").partition(". ")
        return Finding.error(name, problem, remedy, kind=failure.kind)
    if found is None:
        paths = " or ".join(map(repr, bound.settings.path))
        return Finding.ok(name, f"the scene has no object {paths}, so pictures stay in memory", kind="kept-in-memory")
    return Finding.ok(name, f"{found.path}, a {found.kind.value}", kind="object-found")
