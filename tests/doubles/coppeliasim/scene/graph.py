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

from tests.doubles.coppeliasim.scene.objects import Node, NoObjectError, SceneError
from tests.doubles.coppeliasim.scene.poses import Transform


def find(roots: Sequence[Node], path: str, index: int = 0, start: Node | None = None) -> Node | None:
    """Return the object with a path; None if there is none.

    ``index`` selects one of several matches. A path that begins with ``./`` is relative to ``start``."""
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


def find_shortest_path(roots: Sequence[Node], node: Node) -> str:
    """Return the shortest unambiguous path of an object, with the models that contain it."""
    path, above = "/" + _format_indexed_alias(roots, node), node.parent
    while above:
        scope = above.parent.children if above.parent else roots
        if above.is_model_base or find(scope, path) is not node:
            path = "/" + _format_indexed_alias(roots, above) + path
        above = above.parent
    return path


def find_full_path(roots: Sequence[Node], node: Node) -> str:
    """Return the path of an object with all its parents."""
    above = find_full_path(roots, node.parent) if node.parent else ""
    return f"{above}/{_format_indexed_alias(roots, node)}"


def _match(level: Sequence[Node], parts: Sequence[str]) -> Iterator[Node]:
    name, number = _split_index(parts[0])
    left, deeper = number or 0, list[Node]()
    for node in level:
        is_fitting = fnmatchcase(node.alias, name)
        if is_fitting and left == 0:
            if len(parts) == 1:
                yield node
            else:
                yield from _match(node.children, parts[1:])
        left -= is_fitting and number is not None
        if not (is_fitting and number is not None):
            deeper.append(node)
    for node in deeper:
        yield from _match(node.children, parts)


def _split_index(part: str) -> tuple[str, int | None]:
    numbered = re.fullmatch(r"(.+)\[(\d+)\]", part)
    return (numbered[1], int(numbered[2])) if numbered else (part, None)


def _format_indexed_alias(roots: Sequence[Node], node: Node) -> str:
    namesakes = [each for each in (node.parent.children if node.parent else roots) if each.alias == node.alias]
    return node.alias if len(namesakes) == 1 else f"{node.alias}[{namesakes.index(node)}]"


ALL, TREE, SINGLE = -2, -6, -8
"""The values of the API's ``handle_...`` for the scope of a collection's item."""


@dataclass
class Collection:
    """A collection of objects, as a list of items.

    Each item adds or removes an object, a tree of objects, or all objects.
    """

    items: list[tuple[int, Node | None, bool]] = field(default_factory=list)

    def add(self, what: int, node: Node | None, *, is_out: bool) -> None:
        if what not in {ALL, TREE, SINGLE}:
            raise SceneError(f"the double has no collection items with the scope {what}.")
        self.items.append((what, node, is_out))

    def members(self, graph: Graph) -> set[Node]:
        """Return the objects that belong to the collection now."""
        found: set[Node] = set()
        for what, node, is_out in self.items:
            named = [node] if node else []
            these = set(graph.tree() if what == ALL else graph.tree(named) if what == TREE else named)
            found = found - these if is_out else found | these
        return found


NodeT = TypeVar("NodeT", bound=Node)


class Graph:
    """The trees of objects in a scene. Handles count upwards and are never used twice.

    ``revision`` changes with each change by a client, so that derived data can be updated.
    """

    def __init__(self, first_handle: int = 0) -> None:
        self.revision = 0
        self.clear(first_handle)

    def clear(self, first_handle: int = 0) -> None:
        """Remove all objects. The next object gets the handle ``first_handle``."""
        self.revision += 1
        self.roots: list[Node] = []
        self.collections: dict[int, Collection] = {}
        self._nodes: dict[int, Node] = {}
        self._handles = itertools.count(first_handle)

    def __getitem__(self, handle: int) -> Node:
        try:
            return self._nodes[handle]
        except KeyError:
            raise NoObjectError from None

    def get(self, handle: int) -> Node | None:
        """Return the object with this handle; None if there is none."""
        return self._nodes.get(handle)

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
        self.revision += 1
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
        self.revision += 1

    def pose(self, node: Node) -> Transform:
        """Return the pose of an object in the world."""
        return self.frame(node.parent).compose(node.local) if node.parent else node.local

    def frame(self, node: Node | None) -> Transform:
        """Return the frame of an object's children in the world; None stands for the world."""
        if node is None:
            return Transform()
        return self.frame(node.parent).compose(node.children_frame) if node.parent else node.children_frame

    def put(self, node: Node, pose: Transform) -> None:
        """Set the pose of an object in the world. Its children move with it."""
        node.local = self.frame(node.parent).inverse.compose(pose) if node.parent else pose
        self.revision += 1

    def tree(self, roots: Iterable[Node] | None = None) -> list[Node]:
        """Return objects and all objects below them, level by level. By default they are those of the whole scene."""
        level, found = list(self.roots if roots is None else roots), list[Node]()
        while level:
            found += level
            level = [child for node in level for child in node.children]
        return found

    def find(self, path: str, index: int = 0, start: Node | None = None) -> Node | None:
        """Return the object with a path, such as ``/rover/leftMotor``; None if there is none."""
        return find(self.roots, path, index, start)

    def find_flat(self, name: str) -> Node | None:
        """Return the object with this name of V-REP or with this alias; None if there is none."""
        by_name = (node for node in self if node.flat_name == name)
        by_alias = (node for node in self if node.alias == name)
        return next(itertools.chain(by_name, by_alias), None)

    def path(self, node: Node) -> str:
        """Return the shortest unambiguous path of an object."""
        return find_shortest_path(self.roots, node)

    def _attach(self, node: Node, parent: Node | None) -> None:
        node.parent = parent
        self._siblings(node).append(node)

    def _siblings(self, node: Node) -> list[Node]:
        return node.parent.children if node.parent else self.roots
