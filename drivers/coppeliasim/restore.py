"""A scene that is somebody's: what is ours in it, what of it is changed meanwhile, and how it becomes as it was.

Our roots carry the calls that give back what was changed, so that whoever comes after a program that was killed can do
it too.
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
"""A function's name and its arguments; an object by its path, for a scene that is saved and loaded has new handles."""

BEGUN = "robotcore.begun"
"""While something is built, its first root notes under this which roots there were before."""

_DOWN_M = 0.5
_FIRST_CHILDREN = 2
_SHOWN = 3


def find_our_roots(builder: SceneBuilder) -> dict[int, str]:
    """Return the roots that are ours, with their notes."""
    notes = {root: builder.note_on(root) for root in _roots(builder)}
    return {root: note for root, note in notes.items() if note}


def begin_building(builder: SceneBuilder, keeper: int) -> None:
    """Note that something is being built; ``keeper`` is its first root."""
    builder.mark(keeper, json.dumps(_roots(builder)), BEGUN)


def finish_building(builder: SceneBuilder, keeper: int) -> None:
    """Note that all has been built, and is under a root that is ours."""
    builder.mark(keeper, "", BEGUN)


def restore(builder: SceneBuilder) -> None:
    """Remove what is ours, and give back what was changed."""
    found = find_our_roots(builder)
    for root in found:
        _remove_stray(builder, root, found)
    for root, note in found.items():
        for name, *arguments in json.loads(note):
            with suppress(RefusedError):  # what somebody has removed meanwhile
                _undo(builder, root, name, arguments)
        builder.remove_tree(root)


def release(builder: SceneBuilder) -> None:
    """Let the sensors that are ours look at every step, as everybody else's do, now that nobody asks them to."""
    for root in find_our_roots(builder):
        for kind in ("object_visionsensor_type", "object_proximitysensor_type"):
            for sensor in builder.tree(root, kind):
                builder.call("setExplicitHandling", sensor, 0)


def require_empty(builder: SceneBuilder) -> None:
    """Raise BackendError where more than a floor stands in the scene."""
    shapes = builder.tree("handle_scene", "object_shape_type")
    paths = [builder.path(shape) for shape in shapes]
    if others := [path for path in paths if not _is_floor(path)]:
        shown = ", ".join(others[:_SHOWN]) + (", …" if len(others) > _SHOWN else "")
        raise BackendError(
            f"coppeliasim: there are things in the scene ({shown}), and the world would be built among them. Open a "
            "new scene in CoppeliaSim, or drive the robot that is there: --robot, with a file that names its objects "
            "under [coppeliasim], as bubblerob and lookout do"
        )


def save_scene_state(builder: SceneBuilder, keeper: int, light: Light, more: Sequence[Undo]) -> None:
    """Light the scene as described, and lower its floor under ours.

    ``keeper`` is the root that keeps how it was, and what ``more`` there is to be undone.
    """
    lamps = builder.tree("handle_scene", "object_light_type")
    places = {root: builder.place(root) for root in _roots(builder) if _is_floor(builder.path(root))}
    ambient = builder.constant("arrayparam_ambient_light")
    undo: list[Undo] = [*more, ("setArrayParam", ambient, builder.call("getArrayParam", ambient))]
    undo += [("setObjectPose", builder.path(floor), list(place)) for floor, place in places.items()]
    undo += [call for lamp in lamps for call in _undo_lamp(builder, lamp)]
    builder.mark(keeper, json.dumps(undo))
    builder.call("setArrayParam", ambient, [light.ambient * light.brightness] * 3)
    for floor, place in places.items():
        builder.call("setObjectPose", floor, list(place._replace(z=place.z - _DOWN_M)))
    for number, lamp in enumerate(lamps):
        _set_lamp(builder, lamp, light, is_on=number == 0)


def undo_collections(keeper: int, collections: Collection[int]) -> list[Undo]:
    """Return how collections are undone, which have no names: only where their ``keeper`` still has its handle."""
    return [("destroyCollection", collection, keeper) for collection in collections]


def _undo(builder: SceneBuilder, root: int, name: str, arguments: list[Any]) -> None:
    first, *rest = arguments
    if name == "destroyCollection":
        if rest == [root]:
            builder.call(name, first)
    else:
        builder.call(name, builder.make("getObject", first) if isinstance(first, str) else first, *rest)


def _remove_stray(builder: SceneBuilder, keeper: int, found: Collection[int]) -> None:
    """Remove the one object that was made when building was cut short, and had no parent yet.

    Two or more that are new are not ours alone: they stay.
    """
    if not (begun := builder.note_on(keeper, BEGUN)):
        return
    strays = set(_roots(builder)) - set(json.loads(begun)) - set(found)
    if len(strays) == 1:
        builder.remove_tree(strays.pop())


def _roots(builder: SceneBuilder) -> list[int]:
    return builder.tree("handle_scene", options=_FIRST_CHILDREN)


def _undo_lamp(builder: SceneBuilder, lamp: int) -> list[Undo]:
    state, _, diffuse, specular = builder.lamp(lamp)
    path = builder.path(lamp)
    pose = ("setObjectPose", path, list(builder.place(lamp)))
    return [("setLightParameters", path, state, None, diffuse, specular), pose]


def _set_lamp(builder: SceneBuilder, lamp: int, light: Light, *, is_on: bool) -> None:
    """Let a lamp that shines along its z axis, from everywhere alike, be the world's, or none."""
    diffuse = [light.diffuse * light.brightness] * 3
    builder.call("setLightParameters", lamp, int(is_on), None, diffuse, [0.0, 0.0, 0.0])
    builder.call("setObjectPose", lamp, list(place_lamp(light)))


def _is_floor(path: str) -> bool:
    return "floor" in path.split("/")[1].lower()
