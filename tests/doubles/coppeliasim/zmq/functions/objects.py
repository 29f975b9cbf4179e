"""The functions about objects: paths, handles, names, parents and collections."""

from __future__ import annotations

from typing import Any

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.graph import ALL, Collection, find_full_path
from tests.doubles.coppeliasim.scene.objects import Lamp, Node, NoObjectError
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session

HANDLE_SCENE = -12
HANDLE_ALL = -2

PATHLESS = "object does not exist, or alias/path is ill formatted."


class PathError(NoObjectError):
    """No object has the path. The server's error names its inner function ``where``."""

    def __init__(self, where: str) -> None:
        super().__init__(PATHLESS)
        self.where = where


@function("getObject")
def get_object(session: Session, path: str, options: dict[str, Any] | None = None) -> int:
    settings = options or {}
    proxy = settings.get("proxy")
    start = session.simulator.graph[proxy] if proxy is not None else None
    found = session.simulator.graph.find(path, settings.get("index", 0), start)
    if found is None and not settings.get("noError"):
        raise PathError("1254: in sim._getObject")
    return found.handle if found else -1


@function("getObjectHandle")
def get_object_handle(session: Session, name: str, options: dict[str, Any] | None = None) -> int:
    if name.startswith((".", "/", ":")):
        return get_object(session, name, options)
    found = session.simulator.graph.find_flat(name)
    if found is None and not (options or {}).get("noError"):
        raise PathError("1272: in sim._getObjectHandle")
    return found.handle if found else -1


@function("isHandle")
def is_handle(session: Session, handle: int) -> bool:
    return handle in session.simulator.graph


@function("getObjectType")
def get_object_type(session: Session, node: Node) -> int:
    return int(node.type)


@function("getObjectAlias")
def get_object_alias(session: Session, node: Node, option: int = -1) -> str:
    graph = session.simulator.graph
    if option in {1, 5}:
        return graph.path(node)
    if option == 2:
        return find_full_path(graph.roots, node)
    if option == 4:
        return f"{node.alias}__{node.handle}__"
    if option in {-1, 0}:
        return node.alias
    raise SceneError(f"the double has no alias of option {option}.")


@function("setObjectAlias")
def set_object_alias(session: Session, node: Node, alias: str) -> None:
    node.alias = node.flat_name = alias


@function("getObjectName")
def get_object_name(session: Session, node: Node) -> str:
    return node.flat_name


@function("getObjectParent")
def get_object_parent(session: Session, node: Node) -> int:
    return node.parent.handle if node.parent else -1


@function("setObjectParent")
def set_object_parent(session: Session, node: Node, parent: int, in_place: bool = True) -> int:  # noqa: FBT002
    graph = session.simulator.graph
    graph.move_under(node, graph[parent] if parent != -1 else None, in_place=in_place)
    return 1


@function("getObjectChild")
def get_object_child(session: Session, parent: int, index: int) -> int:
    graph = session.simulator.graph
    children = graph[parent].children if parent != -1 else graph.roots
    return children[index].handle if 0 <= index < len(children) else -1


@function("getObjectsInTree")
def get_objects_in_tree(session: Session, root: int, kind: int = HANDLE_ALL, options: int = 0) -> list[int]:
    """Return handles. Bits of the options: 0 omits the root, 1 omits all objects below its children."""
    graph = session.simulator.graph
    if root == HANDLE_SCENE:
        found = graph.roots if options & 2 else graph.tree()
    else:
        base = graph[root]
        found = [] if options & 1 else [base]
        found = found + (base.children if options & 2 else graph.tree(base.children))
    return [node.handle for node in found if kind in {HANDLE_ALL, node.type}]


@function("getObjects")
def get_objects(session: Session, index: int, kind: int) -> int:
    fitting = [node.handle for node in session.simulator.graph if kind in {HANDLE_ALL, node.type}]
    return fitting[index] if index < len(fitting) else -1


@function("removeObjects")
def remove_objects(session: Session, handles: list[int], delayed: bool = False) -> None:  # noqa: FBT002
    graph = session.simulator.graph
    if any(handle not in graph for handle in handles):
        raise SceneError("found invalid handles.")
    for handle in handles:
        graph.remove(graph[handle])


@function("removeObject")
def remove_object(session: Session, node: Node) -> int:
    session.simulator.graph.remove(node)
    return 1


@function("removeModel")
def remove_model(session: Session, node: Node) -> int:
    if not node.is_model_base:
        raise SceneError("object is not tagged as model base.")
    tree = session.simulator.graph.tree([node])
    for each in reversed(tree):
        session.simulator.graph.remove(each)
    return len(tree)


FIRST = 2000000
"""The first handle of a collection, far from the handles of objects."""

TAKE_OUT = 1


@function("createCollection")
def create_collection(session: Session, options: int = 0) -> int:
    collections = session.simulator.graph.collections
    handle = max(collections, default=FIRST - 1) + 1
    collections[handle] = Collection()
    return handle


@function("addItemToCollection")
def add_item_to_collection(session: Session, handle: int, what: int, member: int, options: int = 0) -> None:
    graph = session.simulator.graph
    _of(session, handle).add(what, None if what == ALL else graph[member], is_out=bool(options & TAKE_OUT))
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


@function("getLightParameters")
def get_light_parameters(session: Session, lamp: Lamp) -> tuple[int, list[float], list[float], list[float]]:
    """Return whether the lamp is on, an unused value, and its diffuse and specular colours."""
    return int(lamp.is_on), [0.0, 0.0, 0.0], list(lamp.diffuse), list(lamp.specular)


@function("setLightParameters")
def set_light_parameters(
    session: Session,
    lamp: Lamp,
    state: int,
    relic: Any = None,
    diffuse: Any = None,
    specular: Any = None,
) -> None:
    lamp.is_on, lamp.is_set = bool(state), True
    if diffuse:
        lamp.diffuse = (float(diffuse[0]), float(diffuse[1]), float(diffuse[2]))
    if specular:
        lamp.specular = (float(specular[0]), float(specular[1]), float(specular[2]))
    session.simulator.graph.revision += 1
