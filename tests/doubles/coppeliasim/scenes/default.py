"""The scene that the simulator begins with: cameras of its window, lamps, a floor."""

from __future__ import annotations

from tests.doubles.coppeliasim.scene import Graph, Simulator
from tests.doubles.coppeliasim.scene.objects import Camera, Dummy, Lamp, Shape
from tests.doubles.coppeliasim.scene.poses import Transform

FLOOR = "ResizableFloor_5_25"
SLAB_M = (5.0, 5.0, 0.1)
CAMERAS = ("XView", "YView", "ZView", "NXView", "NYView", "NZView")


def default_scene() -> Simulator:
    """Return a simulator as it is after its start."""
    simulator = Simulator()
    fill_default_scene(simulator)
    return simulator


def fill_default_scene(simulator: Simulator) -> None:
    """Empty the scene and fill it as recorded: handles 0 to 14, the next is 15."""
    simulator.empty()
    graph = simulator.graph
    graph.add(Camera("DefaultCamera"))
    _add_floor(graph)
    lights = graph.add(Dummy("DefaultLights", is_model_base=True))
    for letter in "ABCD":
        graph.add(Lamp(f"DefaultLight{letter}"), lights)
    for view in CAMERAS:
        graph.add(Camera(f"Default{view}Camera"))


def _add_floor(graph: Graph) -> None:
    base = graph.add(Dummy(FLOOR, is_model_base=True))
    slab = Shape(f"{FLOOR}_element", size=SLAB_M, is_respondable=True, local=Transform((0.0, 0.0, -SLAB_M[2] / 2)))
    graph.add(Shape(f"{FLOOR}_visibleElement", size=SLAB_M), graph.add(slab, base))
