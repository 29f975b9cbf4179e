"""The trees of objects in a scene, and objects by path, such as ``/rover/leftMotor``.

As in the simulator, a path need not name each parent: ``/leftMotor`` finds ``/rover/leftMotor`` too. The object nearest
to the root is found first.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from typing import TypeVar

from tests.doubles.coppeliasim.scene.objects import Node, NoObjectError
from tests.doubles.coppeliasim.scene.poses import ORIGIN, Transform

NodeT = TypeVar("NodeT", bound=Node)


class Graph:
    """The trees of objects in a scene. Handles count upwards and are never used twice.

    ``revision`` changes with each change by a client, so that derived data can be updated. ``collections`` has the
    members of each collection by its handle.
    """

    def __init__(self, first_handle: int = 0) -> None:
        self.revision = 0
        self.roots: list[Node] = []
        self.collections: dict[int, set[Node]] = {}
        self._nodes: dict[int, Node] = {}
        self._handles = itertools.count(first_handle)

    def __getitem__(self, handle: int) -> Node:
        try:
            return self._nodes[handle]
        except KeyError:
            raise NoObjectError from None

    def __iter__(self) -> Iterator[Node]:
        return iter(self._nodes.values())

    def __contains__(self, handle: object) -> bool:
        return handle in self._nodes

    def all_of(self, kind: type[NodeT]) -> list[NodeT]:
        """Return the objects of a class, ordered by handle."""
        return [node for node in self if isinstance(node, kind)]

    def add(self, node: NodeT, parent: Node | None = None) -> NodeT:
        """Add an object below a parent. Its pose is relative to the parent's frame."""
        node.handle = next(self._handles)
        node.flat_name = node.flat_name or node.alias
        self._nodes[node.handle] = node
        self._attach(node, parent)
        return node

    def remove(self, node: Node) -> None:
        """Remove an object. Its children keep their poses in the world, and move to its parent."""
        for child in list(node.children):
            self.move_under(child, node.parent)
        self._siblings(node).remove(node)
        del self._nodes[node.handle]
        self.revision += 1

    def move_under(self, node: Node, parent: Node | None, *, in_place: bool = True) -> None:
        """Move an object to another parent. With ``in_place`` it keeps its pose in the world."""
        pose = self.pose(node)
        self._siblings(node).remove(node)
        self._attach(node, parent)
        if in_place:
            self.put(node, pose)

    def pose(self, node: Node | None) -> Transform:
        """Return the pose of an object in the world; None stands for the world."""
        if node is None:
            return ORIGIN
        return self.pose(node.parent).compose(node.local) if node.parent else node.local

    def put(self, node: Node, pose: Transform) -> None:
        """Set the pose of an object in the world. Its children move with it."""
        node.local = self.pose(node.parent).inverse.compose(pose) if node.parent else pose
        self.revision += 1

    def tree(self, roots: Iterable[Node] | None = None) -> list[Node]:
        """Return objects and all objects below them, level by level. By default they are those of the whole scene."""
        level, found = list(self.roots if roots is None else roots), list[Node]()
        while level:
            found += level
            level = [child for node in level for child in node.children]
        return found

    def find(self, path: str) -> Node | None:
        """Return the object with a path; None if there is none."""
        if not path.startswith("/"):
            return None
        *above, alias = path[1:].split("/")
        fitting = (node for node in self.tree() if node.alias == alias and _has_parents(node, above))
        return next(fitting, None)

    def find_flat(self, name: str) -> Node | None:
        """Return the object with this name of V-REP or with this alias; None if there is none."""
        by_name = (node for node in self if node.flat_name == name)
        by_alias = (node for node in self if node.alias == name)
        return next(itertools.chain(by_name, by_alias), None)

    def path(self, node: Node) -> str:
        """Return the path of an object, with the models that contain it, and with all parents if this is ambiguous."""
        parents = list(_iterate_parents(node))[::-1]
        path = _join([parent for parent in parents if parent.is_model_base], node)
        return path if self.find(path) is node else _join(parents, node)

    def _attach(self, node: Node, parent: Node | None) -> None:
        node.parent = parent
        self._siblings(node).append(node)
        self.revision += 1

    def _siblings(self, node: Node) -> list[Node]:
        return node.parent.children if node.parent else self.roots


def _iterate_parents(node: Node) -> Iterator[Node]:
    while node.parent:
        node = node.parent
        yield node


def _has_parents(node: Node, aliases: list[str]) -> bool:
    """Return whether objects with these aliases are above an object, in this order, maybe with others between them."""
    parents = (parent.alias for parent in _iterate_parents(node))
    return all(alias in parents for alias in reversed(aliases))


def _join(parents: list[Node], node: Node) -> str:
    return "".join(f"/{each.alias}" for each in (*parents, node))
