"""Objects by path and name."""

from __future__ import annotations

import pytest

from tests.doubles.coppeliasim.scene import Graph
from tests.doubles.coppeliasim.scene.objects import Dummy, Node


@pytest.fixture
def graph() -> Graph:
    graph = Graph()
    robot = graph.add(Dummy("robot", is_model_base=True))
    arm = graph.add(Dummy("arm"), robot)
    graph.add(Dummy("hand"), arm)
    for _ in range(3):
        graph.add(Dummy("wheel"), robot)
    graph.add(Dummy("wheel"))
    return graph


def handles(graph: Graph, *paths: str) -> list[int | None]:
    found = [graph.find(path) for path in paths]
    return [node.handle if node else None for node in found]


@pytest.mark.parametrize(
    "path, handle",
    [
        ("/robot", 0),
        ("/robot/arm/hand", 2),
        ("/robot/hand", 2),
        ("/hand", 2),
        ("/robot/wheel", 3),
        ("/robot/wheel[0]", 3),
        ("/robot/wheel[2]", 5),
        ("/wheel", 6),
        ("/rob*/h?nd", 2),
    ],
)
def test_path_finds_an_object(graph: Graph, path: str, handle: int) -> None:
    assert handles(graph, path) == [handle]


@pytest.mark.parametrize("path", ["/unknown", "/robot/wheel[3]", "/arm/wheel", "robot", "/", "/robot/", ""])
def test_path_without_an_object(graph: Graph, path: str) -> None:
    assert handles(graph, path) == [None]


def test_path_can_begin_at_an_object(graph: Graph) -> None:
    assert graph.find("./hand", start=graph[0]) is graph[2]
    assert graph.find("./robot", start=graph[1]) is None
    assert graph.find(".", start=graph[1]) is graph[1]


def test_index_selects_a_match(graph: Graph) -> None:
    assert [graph.find("/robot/wheel", index) for index in range(4)] == [graph[3], graph[4], graph[5], None]


def test_shortest_path_finds_the_object(graph: Graph) -> None:
    paths = {node.handle: graph.path(node) for node in graph}
    assert paths[2] == "/robot/hand"
    assert paths[4] == "/robot/wheel[1]"
    assert handles(graph, *paths.values()) == list(paths)


def test_children_of_a_removed_object_keep_their_places(graph: Graph) -> None:
    hand: Node = graph[2]
    place = graph.pose(hand)
    graph.remove(graph[1])
    assert hand.parent is graph[0]
    assert graph.pose(hand) == place
    assert 1 not in graph
