"""Restore the user's scene: remove the objects that this driver made, and undo its changes.

The root objects that this driver makes store the calls that undo its changes. So if a program is killed, the next
program can restore the scene.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from contextlib import suppress
from typing import Any

from drivers.coppeliasim.builder import SceneBuilder, place_lamp
from drivers.coppeliasim.connection import RefusedError
from robotcore.description import Light
from robotcore.errors import BackendError

Undo = Sequence[object]
"""The name of an API function, and its arguments.

An object is named by its path, because handles change when a saved scene is loaded.
"""

BUILDING_TAG = "robotcore.begun"
"""The tag of the list that `begin_building` stores."""

_DOWN_M = 0.5
_FIRST_CHILDREN = 2
_MAX_SHOWN = 3


def find_own_roots(builder: SceneBuilder) -> dict[int, str]:
    """Return the notes of the root objects that this driver made, by the handles of these objects."""
    notes = {root: builder.read_note(root) for root in _list_roots(builder)}
    return {root: note for root, note in notes.items() if note}


def begin_building(builder: SceneBuilder, keeper: int) -> None:
    """Store the list of the scene's root objects, so that `restore` can find an object without a mark.

    A killed program can leave such an object.

    keeper: the handle of the first root object that is built. It stores the list.
    """
    builder.mark(keeper, json.dumps(_list_roots(builder)), BUILDING_TAG)


def finish_building(builder: SceneBuilder, keeper: int) -> None:
    """Clear the list that `begin_building` stored, because now each new object is below a marked root."""
    builder.mark(keeper, "", BUILDING_TAG)


def restore(builder: SceneBuilder) -> None:
    """Remove the objects that this driver made, and undo its changes."""
    found = find_own_roots(builder)
    for root in found:
        _remove_stray(builder, root, found)
    for root, note in found.items():
        for name, *arguments in json.loads(note):
            with suppress(RefusedError):  # the user removed the object
                _undo(builder, root, name, arguments)
        builder.remove_tree(root)


def release(builder: SceneBuilder) -> None:
    """Let CoppeliaSim update the built sensors in every time step.

    Programs that join the scene later read the sensors without requesting updates.
    """
    for root in find_own_roots(builder):
        for kind in ("object_visionsensor_type", "object_proximitysensor_type"):
            for sensor in builder.list_tree(root, kind):
                builder.call("setExplicitHandling", sensor, 0)


def require_empty(builder: SceneBuilder) -> None:
    """Raise BackendError if the scene has shapes other than a floor."""
    shapes = builder.list_tree("handle_scene", "object_shape_type")
    paths = [builder.read_path(shape) for shape in shapes]
    if others := [path for path in paths if not _is_floor(path)]:
        shown = ", ".join(others[:_MAX_SHOWN]) + (", …" if len(others) > _MAX_SHOWN else "")
        raise BackendError(
            f"coppeliasim: the scene is not empty ({shown}), and the world would be built among its objects. Open a "
            "new scene in CoppeliaSim, or drive the robot in this one: --robot with a file that names its objects "
            "under [coppeliasim], as bubblerob and lookout do",
            kind="scene-not-empty",
            paths=others,
        )


def save_scene_state(builder: SceneBuilder, keeper: int, light: Light, more: Sequence[Undo]) -> None:
    """Store the calls that undo changes; then set the light of the world and lower the floor of the user's scene.

    keeper: the handle of the root object that stores these calls.
    light: the light of the world.
    more: further calls to store.
    """
    lamps = builder.list_tree("handle_scene", "object_light_type")
    places = {root: builder.read_placement(root) for root in _list_roots(builder) if _is_floor(builder.read_path(root))}
    ambient = builder.constant("arrayparam_ambient_light")
    undo: list[Undo] = [*more, ("setArrayParam", ambient, builder.call("getArrayParam", ambient))]
    undo += [("setObjectPose", builder.read_path(floor), list(place)) for floor, place in places.items()]
    undo += [call for lamp in lamps for call in _build_lamp_undo(builder, lamp)]
    builder.mark(keeper, json.dumps(undo))
    builder.call("setArrayParam", ambient, [light.ambient * light.brightness] * 3)
    for floor, place in places.items():
        builder.call("setObjectPose", floor, list(place._replace(z=place.z - _DOWN_M)))
    for number, lamp in enumerate(lamps):
        _set_lamp(builder, lamp, light, is_on=number == 0)


def build_collections_undo(keeper: int, collections: Collection[int]) -> list[Undo]:
    """Return the calls that remove collections.

    A collection has a handle and no path, and handles change when a saved scene is loaded. So each call contains the
    handle of ``keeper``. If ``keeper`` has another handle later, `restore` skips the call.
    """
    return [("destroyCollection", collection, keeper) for collection in collections]


def _undo(builder: SceneBuilder, root: int, name: str, arguments: list[Any]) -> None:
    first, *rest = arguments
    if name == "destroyCollection":
        if rest == [root]:
            builder.call(name, first)
    else:
        builder.call(name, builder.make("getObject", first) if isinstance(first, str) else first, *rest)


def _remove_stray(builder: SceneBuilder, keeper: int, found: Collection[int]) -> None:
    """Remove the object that a killed program had made, but not yet attached to a parent.

    There is at most one such object. If two or more root objects are new, the user has made some, and all stay.
    """
    if not (roots_before := builder.read_note(keeper, BUILDING_TAG)):
        return
    strays = set(_list_roots(builder)) - set(json.loads(roots_before)) - set(found)
    if len(strays) == 1:
        builder.remove_tree(strays.pop())


def _list_roots(builder: SceneBuilder) -> list[int]:
    return builder.list_tree("handle_scene", options=_FIRST_CHILDREN)


def _build_lamp_undo(builder: SceneBuilder, lamp: int) -> list[Undo]:
    state, _, diffuse, specular = builder.read_lamp(lamp)
    path = builder.read_path(lamp)
    pose = ("setObjectPose", path, list(builder.read_placement(lamp)))
    return [("setLightParameters", path, state, None, diffuse, specular), pose]


def _set_lamp(builder: SceneBuilder, lamp: int, light: Light, *, is_on: bool) -> None:
    """Give a directional lamp the direction and colour of the world's light, or switch the lamp off."""
    diffuse = [light.diffuse * light.brightness] * 3
    builder.call("setLightParameters", lamp, int(is_on), None, diffuse, [0.0, 0.0, 0.0])
    builder.call("setObjectPose", lamp, list(place_lamp(light)))


def _is_floor(path: str) -> bool:
    return "floor" in path.split("/")[1].lower()
