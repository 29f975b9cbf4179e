"""The objects of a scene that a robot's devices are, looked for all at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from robotcore.description import CameraDescription, MotorDescription, RangeSensorDescription
from robotcore.errors import DeviceError, DeviceGroupError, nearest
from robotcore.simulation.remote_scene.pictures import intrinsics_of
from robotcore.simulation.remote_scene.port import Scene, SceneObject
from robotcore.simulation.remote_scene.section import LensPlace, Placed, ScreenPlace

Found = dict[str, SceneObject | None]
"""By the device's name, the object that it is; None for a display that a scene may do without, and does."""


def find_all(robot: str, placed: Sequence[Placed], scene: Scene) -> Found:
    """Return the object of each device; raises DeviceError or DeviceGroupError with all that is not as it should be."""
    found, failures = {}, []
    for each in placed:
        try:
            found[each.told.name] = find(each, scene)
        except DeviceError as failure:  # noqa: PERF203  every one that fails is to be named
            failures.append(failure)
    failures += _shared_motors(placed, found)
    if len(failures) == 1:
        raise failures[0]
    if failures:
        raise DeviceGroupError(f"opening {robot}", failures)
    return found


def find(placed: Placed, scene: Scene) -> SceneObject | None:
    """Return the object that a device is, at the first of its paths where there is one.

    None where there is none, and the scene may do without; else raises DeviceError, which says what was probably meant.
    Also where the object is of another kind, sees otherwise than described, or is not to be believed.
    """
    there = next((thing for path in placed.place.path if (thing := scene.find(path))), None)
    if there is None:
        if isinstance(placed.place, ScreenPlace) and placed.place.optional:
            return None
        raise DeviceError(placed.told.name, _missing(placed, scene))
    if there.kind is not placed.kind:
        raise DeviceError(
            placed.told.name,
            f"{there.path!r} is a {there.kind.value}, expected a {placed.kind.value}. {_offered(placed, scene)}",
        )
    _require_fit(placed, there.handle, scene)
    return there


def _require_fit(placed: Placed, handle: int, scene: Scene) -> None:
    if isinstance(placed.told, CameraDescription) and isinstance(placed.place, LensPlace):
        intrinsics_of(placed.told, scene.lens(handle), as_found=placed.place.as_found)
    if isinstance(placed.told, RangeSensorDescription) and (why := scene.blindness(handle)):
        raise DeviceError(placed.told.name, why)


def _missing(placed: Placed, scene: Scene) -> str:
    paths = " or ".join(map(repr, placed.place.path))
    return f"the scene has no object {paths}. {_offered(placed, scene)}"


def _offered(placed: Placed, scene: Scene) -> str:
    """Say which object of the right kind, and no other device's, was probably meant, or name them all."""
    paths = [thing.path for thing in scene.objects() if thing.kind is placed.kind]
    free = [path for path in paths if path not in placed.others]
    if close := next((close for path in placed.place.path if (close := nearest(path, free))), None):
        return f"Did you mean {close!r}?"
    return f"The scene's {placed.kind.value}s: {', '.join(sorted(paths)) or 'none'}"


def _shared_motors(placed: Sequence[Placed], found: Found) -> Iterator[DeviceError]:
    """Yield an error for each motor whose joint is another motor's."""
    taken: dict[int, str] = {}
    for name in (each.told.name for each in placed if isinstance(each.told, MotorDescription)):
        if (thing := found.get(name)) and (other := taken.setdefault(thing.handle, name)) != name:
            yield DeviceError(name, f"its joint {thing.path!r} is {other}'s too; name its own one in the file")
