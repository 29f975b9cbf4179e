"""Restore the user's scene: remove the objects that this driver has made, and undo its other changes.

This driver stores the undo calls as a note in a root object that it has made. So after a program was killed, the next
program can restore the scene.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from contextlib import suppress
from typing import Any

from drivers.coppeliasim.address import RefusedError
from drivers.coppeliasim.builder import SceneBuilder, place_lamp
from robotcore.description import Light
from robotcore.errors import BackendError

UndoCall = Sequence[object]
"""A call that undoes a change: the name of an API function, and its arguments.

If the first argument is an object, it is given as a path, because handles change when a saved scene is loaded.
"""

BUILDING_TAG = "robotcore.begun"
"""The name of the custom data in which `begin_building` stores the list of root objects."""

_DOWN_M = 0.5
_FIRST_CHILDREN = 2
_MAX_SHOWN = 3


def find_own_roots(builder: SceneBuilder) -> dict[int, str]:
    """Return the note of each root object that this driver has made, by the handle of the object.

    A note is a JSON list of undo calls.
    """
    notes = {root: builder.read_note(root) for root in _list_roots(builder)}
    return {root: note for root, note in notes.items() if note}


def begin_building(builder: SceneBuilder, storage: int) -> None:
    """Store the list of the scene's root objects, so that `restore` can find new root objects without a note.

    If the program is killed after it has created an object and before it has set its parent, such an object is left.

    storage: the handle of the object that stores the list.
    """
    builder.write_note(storage, json.dumps(_list_roots(builder)), BUILDING_TAG)


def finish_building(builder: SceneBuilder, storage: int) -> None:
    """Clear the list that `begin_building` has stored. Each new object must be below a root object with a note.

    storage: the handle of the object that stores the list.
    """
    builder.write_note(storage, "", BUILDING_TAG)


def restore(builder: SceneBuilder) -> None:
    """Remove the objects that this driver has made, and undo its other changes of the scene."""
    found = find_own_roots(builder)
    for root in found:
        _remove_stray(builder, root, found)
    for root, note in found.items():
        for name, *arguments in json.loads(note):
            with suppress(RefusedError):  # the user removed the object
                _undo(builder, root, name, arguments)
        builder.remove_tree(root)


def enable_sensor_updates(builder: SceneBuilder) -> None:
    """Make CoppeliaSim update the built sensors in each time step, for programs that use the scene later.

    This driver has requested each update itself.
    """
    for root in find_own_roots(builder):
        for kind in ("object_visionsensor_type", "object_proximitysensor_type"):
            for sensor in builder.list_tree(root, kind):
                builder.call("setExplicitHandling", sensor, 0)


def require_empty(builder: SceneBuilder) -> None:
    """Raise BackendError if the scene has a shape that is not a floor."""
    shapes = builder.list_tree("handle_scene", "object_shape_type")
    paths = [builder.read_path(shape) for shape in shapes]
    if others := [path for path in paths if not _is_floor(path)]:
        shown = ", ".join(others[:_MAX_SHOWN]) + (", …" if len(others) > _MAX_SHOWN else "")
        raise BackendError(
            f"coppeliasim: the scene is not empty ({shown}), and the world would be built among its objects. Open a "
            "new scene in CoppeliaSim, or name with --robot a robot of this scene, whose file has a section "
            "[coppeliasim], such as bubblerob or lookout",
            kind="scene-not-empty",
            paths=others,
        )


def save_scene_state(builder: SceneBuilder, storage: int, light: Light, more: Sequence[UndoCall]) -> None:
    """Store the undo calls of the scene. Then set the light of the world, and lower the floor of the user's scene.

    storage: the handle of the root object that stores the undo calls.
    more: further undo calls to store.
    """
    lamps = builder.list_tree("handle_scene", "object_light_type")
    places = {root: builder.read_placement(root) for root in _list_roots(builder) if _is_floor(builder.read_path(root))}
    ambient = builder.constant("arrayparam_ambient_light")
    undo: list[UndoCall] = [*more, ("setArrayParam", ambient, builder.call("getArrayParam", ambient))]
    undo += [("setObjectPose", builder.read_path(floor), list(place)) for floor, place in places.items()]
    undo += [call for lamp in lamps for call in _build_lamp_undo(builder, lamp)]
    builder.write_note(storage, json.dumps(undo))
    builder.call("setArrayParam", ambient, [light.ambient * light.brightness] * 3)
    for floor, place in places.items():
        builder.call("setObjectPose", floor, list(place._replace(z=place.z - _DOWN_M)))
    for number, lamp in enumerate(lamps):
        _set_directional_lamp(builder, lamp, light, is_on=number == 0)


def build_collections_undo(storage: int, collections: Collection[int]) -> list[UndoCall]:
    """Return the undo calls that remove collections.

    storage: the handle of the root object that stores the calls.
    collections: the handles of the collections.

    A collection has no path, and handles change when a saved scene is loaded. So each call contains the handle of
    ``storage`` too. `restore` skips the call if ``storage`` then has another handle.
    """
    return [("destroyCollection", collection, storage) for collection in collections]


def _undo(builder: SceneBuilder, root: int, name: str, arguments: list[Any]) -> None:
    first, *rest = arguments
    if name == "destroyCollection":
        if rest == [root]:
            builder.call(name, first)
    else:
        builder.call(name, builder.make("getObject", first) if isinstance(first, str) else first, *rest)


def _remove_stray(builder: SceneBuilder, storage: int, found: Collection[int]) -> None:
    """Remove the object that a killed program had created, but had not yet attached to a parent.

    There is at most one such object. If there are several new root objects, the user has made some, and all stay.
    """
    if not (roots_before := builder.read_note(storage, BUILDING_TAG)):
        return
    strays = set(_list_roots(builder)) - set(json.loads(roots_before)) - set(found)
    if len(strays) == 1:
        builder.remove_tree(strays.pop())


def _list_roots(builder: SceneBuilder) -> list[int]:
    return builder.list_tree("handle_scene", options=_FIRST_CHILDREN)


def _build_lamp_undo(builder: SceneBuilder, lamp: int) -> list[UndoCall]:
    state, _, diffuse, specular = builder.read_lamp(lamp)
    path = builder.read_path(lamp)
    pose = ("setObjectPose", path, list(builder.read_placement(lamp)))
    return [("setLightParameters", path, state, None, diffuse, specular), pose]


def _set_directional_lamp(builder: SceneBuilder, lamp: int, light: Light, *, is_on: bool) -> None:
    diffuse = [light.diffuse * light.brightness] * 3
    builder.call("setLightParameters", lamp, int(is_on), None, diffuse, [0.0, 0.0, 0.0])
    builder.call("setObjectPose", lamp, list(place_lamp(light)))


def _is_floor(path: str) -> bool:
    return "floor" in path.split("/")[1].lower()
