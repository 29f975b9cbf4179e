"""The objects of a scene, by handle, and which sits on which."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from typing import TypeVar

from tests.doubles.coppeliasim.scene import paths
from tests.doubles.coppeliasim.scene.errors import NoObjectError
from tests.doubles.coppeliasim.scene.groups import Collection
from tests.doubles.coppeliasim.scene.objects import Thing
from tests.doubles.coppeliasim.scene.poses import Transform

ThingT = TypeVar("ThingT", bound=Thing)


class Graph:
    """A forest of things. Handles count upwards and are never given twice.

    ``revision`` changes with everything that somebody outside changes: what is derived from the graph is made anew.
    """

    def __init__(self, first_handle: int = 0) -> None:
        self.revision = 0
        self.clear(first_handle)

    def clear(self, first_handle: int = 0) -> None:
        """Take everything out; handles begin anew."""
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
        """Return the things of one kind, by handle."""
        return [thing for thing in self if isinstance(thing, kind)]

    def add(self, thing: ThingT, parent: Thing | None = None) -> ThingT:
        """Give it a handle and put it under a parent, in whose frame its place is."""
        thing.handle = next(self._handles)
        thing.flat_name = thing.flat_name or thing.alias
        self._things[thing.handle] = thing
        self._hang(thing, parent)
        self.revision += 1
        return thing

    def remove(self, thing: Thing) -> None:
        """Take it out; its children stay where they are, on its parent."""
        for child in list(thing.children):
            self.move_under(child, thing.parent)
        self._siblings(thing).remove(thing)
        del self._things[thing.handle]
        self.revision += 1

    def move_under(self, thing: Thing, parent: Thing | None, *, in_place: bool = True) -> None:
        """Give it another parent; ``in_place``: it stays where it is in the world."""
        pose = self.pose(thing)
        self._siblings(thing).remove(thing)
        self._hang(thing, parent)
        if in_place:
            self.put(thing, pose)
        self.revision += 1

    def pose(self, thing: Thing) -> Transform:
        """Return where it is in the world."""
        return self.frame(thing.parent).then(thing.local) if thing.parent else thing.local

    def frame(self, thing: Thing | None) -> Transform:
        """Return the frame that its children are in, in the world; the world's own for None."""
        if thing is None:
            return Transform()
        return self.frame(thing.parent).then(thing.carried) if thing.parent else thing.carried

    def put(self, thing: Thing, pose: Transform) -> None:
        """Put it somewhere in the world, with all that it carries."""
        thing.local = self.frame(thing.parent).inverse.then(pose) if thing.parent else pose
        self.revision += 1

    def tree(self, roots: Iterable[Thing] | None = None) -> list[Thing]:
        """Return things and all below them, level by level; those of the whole scene where no root is named."""
        level, found = list(self.roots if roots is None else roots), list[Thing]()
        while level:
            found += level
            level = [child for thing in level for child in thing.children]
        return found

    def find(self, path: str, index: int = 0, start: Thing | None = None) -> Thing | None:
        """Return the object that a path like ``/rover/leftMotor`` names, or None."""
        return paths.find(self.roots, path, index, start)

    def find_flat(self, name: str) -> Thing | None:
        """Return the object that V-REP called so, or that has such an alias, or None."""
        by_name = (thing for thing in self if thing.flat_name == name)
        by_alias = (thing for thing in self if thing.alias == name)
        return next(itertools.chain(by_name, by_alias), None)

    def path(self, thing: Thing) -> str:
        """Return the shortest path that names it."""
        return paths.shortest(self.roots, thing)

    def _hang(self, thing: Thing, parent: Thing | None) -> None:
        thing.parent = parent
        self._siblings(thing).append(thing)

    def _siblings(self, thing: Thing) -> list[Thing]:
        return thing.parent.children if thing.parent else self.roots
