"""Objects by path: ``/rover/leftMotor``, ``./camera`` from an object, ``/box[1]``, wildcards ``*`` and ``?``.

As in the simulator, a path need not name each parent: ``/leftMotor`` finds ``/rover/leftMotor`` too. The object nearest
to the root is found first.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from typing import TypeVar

from tests.doubles.coppeliasim.scene.objects import NoObjectError, SceneError, Thing
from tests.doubles.coppeliasim.scene.poses import Transform


def find(roots: Sequence[Thing], path: str, index: int = 0, start: Thing | None = None) -> Thing | None:
    """Return the object with a path, or None. ``index`` selects one of several matches; ``./`` begins at ``start``."""
    if path in {".", ":"}:
        return start
    if path.startswith("./"):
        roots, path = (start.children if start else roots), path[1:]
    if not path.startswith("/") or path.endswith("/"):
        return None
    fitting = _match(roots, path[1:].split("/"))
    for _ in range(index):
        next(fitting, None)
    return next(fitting, None)


def find_shortest_path(roots: Sequence[Thing], thing: Thing) -> str:
    """Return the shortest unambiguous path of an object, with the models that contain it."""
    path, above = "/" + _format_indexed_alias(roots, thing), thing.parent
    while above:
        scope = above.parent.children if above.parent else roots
        if above.is_model_base or find(scope, path) is not thing:
            path = "/" + _format_indexed_alias(roots, above) + path
        above = above.parent
    return path


def find_full_path(roots: Sequence[Thing], thing: Thing) -> str:
    """Return the path of an object with all its parents."""
    above = find_full_path(roots, thing.parent) if thing.parent else ""
    return f"{above}/{_format_indexed_alias(roots, thing)}"


def _match(level: Sequence[Thing], parts: Sequence[str]) -> Iterator[Thing]:
    name, number = _split(parts[0])
    left, deeper = number or 0, list[Thing]()
    for thing in level:
        is_fitting = fnmatchcase(thing.alias, name)
        if is_fitting and left == 0:
            if len(parts) == 1:
                yield thing
            else:
                yield from _match(thing.children, parts[1:])
        left -= is_fitting and number is not None
        if not (is_fitting and number is not None):
            deeper.append(thing)
    for thing in deeper:
        yield from _match(thing.children, parts)


def _split(part: str) -> tuple[str, int | None]:
    """Return the alias in a part of a path, and its index if there is one."""
    numbered = re.fullmatch(r"(.+)\[(\d+)\]", part)
    return (numbered[1], int(numbered[2])) if numbered else (part, None)


def _format_indexed_alias(roots: Sequence[Thing], thing: Thing) -> str:
    """Return the alias of an object, with an index if siblings share it."""
    namesakes = [each for each in (thing.parent.children if thing.parent else roots) if each.alias == thing.alias]
    return thing.alias if len(namesakes) == 1 else f"{thing.alias}[{namesakes.index(thing)}]"


ALL, TREE, SINGLE = -2, -6, -8
"""The scope of an item: the API's ``handle_...``."""


@dataclass
class Collection:
    """A collection: its items in order. Each item has a scope and an object, and adds or removes objects."""

    items: list[tuple[int, Thing | None, bool]] = field(default_factory=list)

    def add(self, what: int, thing: Thing | None, *, is_out: bool) -> None:
        if what not in {ALL, TREE, SINGLE}:
            raise SceneError(f"the double collects trees, single objects and all, not {what}.")
        self.items.append((what, thing, is_out))

    def members(self, graph: Graph) -> set[Thing]:
        """Return the present members."""
        found: set[Thing] = set()
        for what, thing, is_out in self.items:
            named = [thing] if thing else []
            these = set(graph.tree() if what == ALL else graph.tree(named) if what == TREE else named)
            found = found - these if is_out else found | these
        return found


ThingT = TypeVar("ThingT", bound=Thing)


class Graph:
    """The trees of objects in a scene. Handles count upwards and are never used twice.

    ``revision`` changes with each change by a client, so that derived data can be updated.
    """

    def __init__(self, first_handle: int = 0) -> None:
        self.revision = 0
        self.clear(first_handle)

    def clear(self, first_handle: int = 0) -> None:
        """Remove all objects, and restart the handles."""
        self.revision += 1
        self.roots: list[Thing] = []
        self.collections: dict[int, Collection] = {}
        self._things: dict[int, Thing] = {}
        self._handles = itertools.count(first_handle)

    def __getitem__(self, handle: int) -> Thing:
        try:
            return self._things[handle]
        except KeyError:
            raise NoObjectError from None

    def get(self, handle: int) -> Thing | None:
        """Return an object by handle, or None."""
        return self._things.get(handle)

    def __iter__(self) -> Iterator[Thing]:
        return iter(self._things.values())

    def __contains__(self, handle: object) -> bool:
        return handle in self._things

    def all_of(self, kind: type[ThingT]) -> list[ThingT]:
        """Return the objects of a class, ordered by handle."""
        return [thing for thing in self if isinstance(thing, kind)]

    def add(self, thing: ThingT, parent: Thing | None = None) -> ThingT:
        """Add an object below a parent; its place is in the parent's frame."""
        thing.handle = next(self._handles)
        thing.flat_name = thing.flat_name or thing.alias
        self._things[thing.handle] = thing
        self._attach(thing, parent)
        self.revision += 1
        return thing

    def remove(self, thing: Thing) -> None:
        """Remove an object. Its children keep their places, and move to its parent."""
        for child in list(thing.children):
            self.move_under(child, thing.parent)
        self._siblings(thing).remove(thing)
        del self._things[thing.handle]
        self.revision += 1

    def move_under(self, thing: Thing, parent: Thing | None, *, in_place: bool = True) -> None:
        """Move an object to another parent; ``in_place`` keeps its place in the world."""
        pose = self.pose(thing)
        self._siblings(thing).remove(thing)
        self._attach(thing, parent)
        if in_place:
            self.put(thing, pose)
        self.revision += 1

    def pose(self, thing: Thing) -> Transform:
        """Return the place of an object in the world."""
        return self.frame(thing.parent).compose(thing.local) if thing.parent else thing.local

    def frame(self, thing: Thing | None) -> Transform:
        """Return the frame of an object's children in the world; None stands for the world."""
        if thing is None:
            return Transform()
        return self.frame(thing.parent).compose(thing.carried) if thing.parent else thing.carried

    def put(self, thing: Thing, pose: Transform) -> None:
        """Place an object in the world, with all its children."""
        thing.local = self.frame(thing.parent).inverse.compose(pose) if thing.parent else pose
        self.revision += 1

    def tree(self, roots: Iterable[Thing] | None = None) -> list[Thing]:
        """Return objects and all below them, level by level; by default those of the whole scene."""
        level, found = list(self.roots if roots is None else roots), list[Thing]()
        while level:
            found += level
            level = [child for thing in level for child in thing.children]
        return found

    def find(self, path: str, index: int = 0, start: Thing | None = None) -> Thing | None:
        """Return the object with a path, such as ``/rover/leftMotor``, or None."""
        return find(self.roots, path, index, start)

    def find_flat(self, name: str) -> Thing | None:
        """Return the object with a name of V-REP or with an alias, or None."""
        by_name = (thing for thing in self if thing.flat_name == name)
        by_alias = (thing for thing in self if thing.alias == name)
        return next(itertools.chain(by_name, by_alias), None)

    def path(self, thing: Thing) -> str:
        """Return the shortest unambiguous path of an object."""
        return find_shortest_path(self.roots, thing)

    def _attach(self, thing: Thing, parent: Thing | None) -> None:
        thing.parent = parent
        self._siblings(thing).append(thing)

    def _siblings(self, thing: Thing) -> list[Thing]:
        return thing.parent.children if thing.parent else self.roots
