"""Pictures by the painter and by rays, depths, and detections."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.doubles.coppeliasim.scene import Graph, SceneError, Simulator
from tests.doubles.coppeliasim.scene.graph import ALL, SINGLE, Collection
from tests.doubles.coppeliasim.scene.objects import Primitive, ProximitySensor, Shape, VisionSensor
from tests.doubles.coppeliasim.scene.poses import Transform
from tests.doubles.coppeliasim.scenes.parts import AHEAD, create_ball, create_floor, create_static

RED = (1.0, 0.0, 0.0)


@pytest.fixture
def simulator() -> Simulator:
    graph = Graph()
    graph.add(create_floor(80.0, 80.0))
    graph.add(create_static("wall", (0.1, 4.0, 0.8), Transform((2.05, 0.0, 0.4)), RED))
    graph.add(create_ball("ball", 0.1, 1.0, 0.2, (0.0, 1.0, 0.0)))
    post = create_static("post", (0.2, 0.2, 0.5), Transform((1.4, -0.3, 0.25)), (0.0, 0.0, 1.0), Primitive.CYLINDER)
    graph.add(post)
    return Simulator(graph)


def eye(simulator: Simulator, width: int = 64, height: int = 48) -> VisionSensor:
    sensor = VisionSensor("eye", width=width, height=height, explicit=True, local=Transform((0.0, 0.0, 0.2), AHEAD))
    return simulator.graph.add(sensor)


def nose(simulator: Simulator, yaw: float = 0.0) -> ProximitySensor:
    at = Transform.rotated(yaw, (0.0, 0.0, 0.1)).compose(Transform((0.0, 0.0, 0.0), AHEAD))
    return simulator.graph.add(ProximitySensor("nose", reach=3.0, cone=0.5, local=at))


def test_painted_picture_equals_ray_casting(simulator: Simulator) -> None:
    sensor = eye(simulator)
    simulator.handle(sensor)
    painted = simulator.picture(sensor).astype(int)
    simulator.graph.add(
        create_static("cloud", (0.1, 0.1, 0.1), Transform((0.0, 0.0, 9.0)))
    )  # the painter cannot draw it
    simulator.handle(sensor)
    off = np.abs(painted - simulator.picture(sensor)).max(axis=2)
    assert (off > 2).mean() < 0.03  # edges, and posts, which have flat sides in the painter


def test_depths_are_along_the_optical_axis(simulator: Simulator) -> None:
    sensor = eye(simulator, 9, 1)
    simulator.handle(sensor)
    depths = simulator.depth(sensor)[0]
    assert depths[0] == pytest.approx(2.0, abs=1e-5)
    assert depths.min() == pytest.approx(1.3, abs=0.02)


def test_depths_of_a_sensor_that_was_never_rendered(simulator: Simulator) -> None:
    sensor = eye(simulator, 9, 1)
    assert simulator.depth(sensor)[0, 0] == 10.0
    simulator.graph.put(sensor, Transform((0.0, 0.0, 5.0), AHEAD))
    simulator.handle(sensor)
    assert 9.99 < simulator.depth(sensor)[0, 0] < 10.0


def test_each_step_renders_sensors_without_explicit_handling(simulator: Simulator) -> None:
    by_hand, by_itself = eye(simulator), eye(simulator)
    by_itself.explicit = False
    with simulator.lock:
        simulator.start()
        simulator.advance()
    assert not simulator.picture(by_hand).any()
    assert simulator.picture(by_itself).any()
    with pytest.raises(SceneError, match="not tagged for explicit handling"):
        simulator.handle(by_itself)


def test_picture_shows_the_time_of_rendering(simulator: Simulator) -> None:
    sensor = eye(simulator)
    simulator.handle(sensor)
    wall = simulator.graph.find("/wall")
    assert isinstance(wall, Shape)
    wall.colour = (1.0, 1.0, 1.0)
    simulator.graph.revision += 1
    before = simulator.picture(sensor)
    simulator.handle(sensor)
    assert (before != simulator.picture(sensor)).any()


@pytest.mark.parametrize(
    "yaw, distance, name",
    [(0.0, 0.924, "ball"), (0.6, 2.0 / math.cos(0.35), "wall"), (-0.3, 1.33, "post")],
)
def test_nearest_object_in_the_cone_is_detected(simulator: Simulator, yaw: float, distance: float, name: str) -> None:
    found = simulator.detection(nose(simulator, yaw))
    assert found
    assert simulator.graph[found.handle].alias == name
    assert found.distance == pytest.approx(distance, abs=0.01)
    assert math.hypot(*found.point) == pytest.approx(found.distance)


def test_object_at_the_sensor_is_detected(simulator: Simulator) -> None:
    sensor = nose(simulator)
    simulator.graph.put(sensor, Transform((1.995, -1.0, 0.1), AHEAD))
    found = simulator.detection(sensor)
    assert found
    assert found.distance == pytest.approx(0.005)


def test_distance_is_measured_from_the_sensor(simulator: Simulator) -> None:
    sensor = nose(simulator)
    simulator.graph.put(sensor, Transform((2.005, -1.0, 0.1), AHEAD))
    assert simulator.detection(sensor) is None  # the rays begin inside the wall
    sensor.setback = 0.05
    assert simulator.detection(sensor)
    simulator.graph.put(sensor, Transform((1.9, -1.0, 0.1), AHEAD))
    found = simulator.detection(sensor)
    assert found
    assert found.distance == pytest.approx(0.1)


def test_sensor_detects_only_its_collection(simulator: Simulator) -> None:
    collection = simulator.graph.collections[1] = Collection()
    collection.add(ALL, None, is_out=False)
    collection.add(SINGLE, simulator.graph.find("/ball"), is_out=True)
    sensor = nose(simulator)
    sensor.entity = 1
    found = simulator.detection(sensor)
    assert found
    assert simulator.graph[found.handle].alias != "ball"


def test_nothing_is_detected_behind_or_beyond_the_range(simulator: Simulator) -> None:
    assert simulator.detection(nose(simulator, math.pi)) is None
    sensor = nose(simulator)
    sensor.reach = 0.9
    assert simulator.detection(sensor) is None


def test_nothing_is_detected_without_the_plug_in(simulator: Simulator) -> None:
    simulator.can_detect = False
    assert simulator.detection(nose(simulator)) is None


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0, 1.0), (0.5, 0.5, 0.5, 0.5), (0.0, math.sin(0.4), 0.0, math.cos(0.4))])
@pytest.mark.parametrize("primitive", list(Primitive))
def test_ray_ends_on_the_surface_of_a_rotated_solid(
    primitive: Primitive, turn: tuple[float, float, float, float]
) -> None:
    graph = Graph()
    solid = graph.add(Shape("solid", primitive=primitive, size=(0.4, 0.4, 0.6), local=Transform((1.0, 0.1, 0.2), turn)))
    sensor = ProximitySensor("ray", reach=3.0, cone=0.0, local=Transform((0.0, 0.1, 0.2), AHEAD))
    found = Simulator(graph).detection(graph.add(sensor))
    assert found
    hit = graph.pose(sensor).apply(found.point)
    x, y, z = (2 * part / size for part, size in zip(graph.pose(solid).inverse.apply(hit), solid.size, strict=True))
    surface = {
        Primitive.CUBOID: max(abs(x), abs(y), abs(z)),
        Primitive.SPHEROID: math.sqrt(x * x + y * y + z * z),
        Primitive.CYLINDER: max(math.hypot(x, y), abs(z)),
    }
    assert surface[primitive] == pytest.approx(1.0)
