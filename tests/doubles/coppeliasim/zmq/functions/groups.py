"""Collections of objects."""

from __future__ import annotations

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.groups import ALL, Collection
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session

FIRST = 2000000
"""Handles of collections are far from those of objects."""

TAKE_OUT = 1


@function("createCollection")
def create_collection(session: Session, options: int = 0) -> int:
    collections = session.simulator.graph.collections
    handle = max(collections, default=FIRST - 1) + 1
    collections[handle] = Collection()
    return handle


@function("addItemToCollection")
def add_item_to_collection(session: Session, handle: int, what: int, thing: int, options: int = 0) -> None:
    graph = session.simulator.graph
    _of(session, handle).add(what, None if what == ALL else graph[thing], is_out=bool(options & TAKE_OUT))
    graph.revision += 1


@function("destroyCollection")
def destroy_collection(session: Session, handle: int) -> None:
    _of(session, handle)
    del session.simulator.graph.collections[handle]


def _of(session: Session, handle: int) -> Collection:
    try:
        return session.simulator.graph.collections[handle]
    except KeyError:
        raise SceneError("collection does not exist.") from None
