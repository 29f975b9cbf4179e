"""A scene that is built, and that is left as it was."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from drivers.coppeliasim.address import Address
from drivers.coppeliasim.backend import CoppeliaSimBackend
from drivers.coppeliasim.builder import NO_UNDO, CollisionMask, Placement, SceneBuilder
from drivers.coppeliasim.client import Client
from drivers.coppeliasim.connection import Connection
from drivers.coppeliasim.restore import begin_building
from robotcore.description import load_robot, load_world
from robotcore.errors import BackendError, DeviceGroupError, UsageError
from robotcore.hal.backend import Setup
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scene.objects import Lamp, Shape, VisionSensor
from tests.doubles.coppeliasim.scenes import bubblerob_scene, default_scene

FLOOR = "/ResizableFloor_5_25"


@pytest.fixture
def simulator() -> Simulator:
    return default_scene()


@pytest.fixture
def port(simulator: Simulator) -> Iterator[int]:
    with Double(simulator) as double:
        yield double.zmq_port


def setup_on(port: int, world: str = "arena", **options: Any) -> Setup:
    robot = load_robot("rover")
    names = frozenset(words.name for words in robot.devices)
    return Setup(robot, load_world(world), names, options={"port": port, **options})


def opened(port: int, **options: Any) -> Any:
    return CoppeliaSimBackend().open(setup_on(port, **options))


def snapshot(simulator: Simulator) -> dict[str, Any]:
    with simulator.lock:
        things = {thing.alias: simulator.graph.pose(thing) for thing in simulator.graph}
        return {"things": things, "step": simulator.time_step}


def test_people_find_world_and_robot_by_path(simulator: Simulator, port: int) -> None:
    with opened(port):
        found = ["/rover", "/rover/left_motor", "/rover/nose", "/rover/eye", "/rover/screen", "/arena/ball"]
        assert all(simulator.graph.find(path) for path in found)


def test_scene_is_left_as_it_was(simulator: Simulator, port: int) -> None:
    before = snapshot(simulator)
    with opened(port) as robot:
        robot.clock.sleep_until(0.2)
        assert snapshot(simulator) != before
    assert snapshot(simulator) == before
    assert not simulator.graph.collections


def test_scene_that_is_kept_is_removed_by_the_next_program(simulator: Simulator, port: int) -> None:
    before = snapshot(simulator)
    opened(port, keep=True).close()
    assert simulator.graph.find("/rover/left_motor")
    opened(port).close()
    assert snapshot(simulator) == before


def test_sensors_of_a_scene_that_is_kept_look_at_every_step_for_whoever_joins_it(
    simulator: Simulator, port: int
) -> None:
    opened(port, keep=True).close()
    eye = simulator.graph.find("/rover/eye")
    assert isinstance(eye, VisionSensor)
    assert not eye.explicit


def test_a_scene_that_is_joined_cannot_be_asked_to_be_kept() -> None:
    setup = Setup(load_robot("bubblerob"), None, frozenset(), options={"keep": "true"})
    with pytest.raises(UsageError, match="the scene is somebody's"):
        CoppeliaSimBackend().open(setup)


def test_kept_scene_that_was_saved_and_loaded_is_cleared_though_its_handles_are_others(
    simulator: Simulator, port: int
) -> None:
    before = snapshot(simulator)
    opened(port, keep=True).close()
    with simulator.lock:
        things, simulator.graph._things = list(simulator.graph), {}
        for handle, thing in enumerate(reversed(things), 100):
            thing.handle = handle
            simulator.graph._things[handle] = thing
    collections = dict(simulator.graph.collections)  # as far as anybody knows, somebody's
    opened(port).close()
    after = snapshot(simulator)
    assert (after["step"], after["things"]) == (before["step"], before["things"])
    assert simulator.graph.collections == collections


def test_floor_and_lamps_of_the_scene_make_way(simulator: Simulator, port: int) -> None:
    with opened(port):
        floor = simulator.graph.find(FLOOR)
        assert floor
        assert simulator.graph.pose(floor).position[2] == pytest.approx(-0.5)
        sun = simulator.graph.all_of(Lamp)[0]
        down = np.array(simulator.graph.pose(sun).axes[2])
        assert -down == pytest.approx(load_world("arena").light.direction)


def test_things_of_somebody_are_not_built_among(simulator: Simulator, port: int) -> None:
    simulator.graph.add(Shape("Table"))
    with pytest.raises(BackendError, match=r"things in the scene \(/Table\)"):
        opened(port)
    assert simulator.graph.find("/Table")
    assert not simulator.graph.find("/rover")


def test_simulation_of_somebody_is_not_stopped(simulator: Simulator, port: int) -> None:
    with simulator.lock:
        simulator.start()
    with pytest.raises(BackendError, match="simulation of somebody's is running"):
        opened(port)
    assert simulator.state.is_advancing


def test_what_was_built_is_removed_where_opening_fails(simulator: Simulator, port: int) -> None:
    before = snapshot(simulator)
    setup = setup_on(port)
    drive = setup.robot.drive
    assert drive
    loose = drive.model_copy(update={"left_encoder": None, "right_encoder": None})
    with pytest.raises(DeviceGroupError, match="sits on no wheel"):
        CoppeliaSimBackend().open(replace(setup, robot=setup.robot.model_copy(update={"drive": loose})))
    assert snapshot(simulator) == before


@pytest.mark.parametrize("last", [10, 23, 40, 77, 130, 163, 170])
def test_what_was_built_is_removed_where_ctrl_c_comes_in_a_call(
    simulator: Simulator, port: int, monkeypatch: pytest.MonkeyPatch, last: int
) -> None:
    before = snapshot(simulator)
    call, left = Connection.call, last

    def cut(self: Connection, *asked: Any, **more: Any) -> Any:
        nonlocal left
        left -= 1
        answer = call(self, *asked, **more)
        if left == 0:  # the answer is lost
            raise KeyboardInterrupt
        return answer

    monkeypatch.setattr(Connection, "call", cut)
    with pytest.raises(KeyboardInterrupt):
        opened(port)
    assert snapshot(simulator) == before


def test_what_a_killed_program_had_just_made_is_removed_by_the_next(simulator: Simulator, port: int) -> None:
    before = snapshot(simulator)
    cut_off_in_building(port, "Sphere")
    opened(port).close()
    assert snapshot(simulator) == before


def test_what_somebody_has_added_since_a_program_was_killed_stays(simulator: Simulator, port: int) -> None:
    cut_off_in_building(port, "Sphere", "Table")
    with pytest.raises(BackendError, match=r"things in the scene \(/Sphere, /Table\)"):
        opened(port)
    assert simulator.graph.find("/Table")


def cut_off_in_building(port: int, *made: str) -> None:
    """Leave a scene as a program does that is killed when these have no parent yet."""
    connection = Connection.open(Address(port=port), 5.0)
    builder = SceneBuilder(connection)
    root = builder.dummy("arena")
    builder.mark(root, NO_UNDO)
    begin_building(builder, root)
    for alias in made:
        builder.shape("spheroid", (0.1,) * 3, Placement(0.0, 0.0, 1.0), (9, 9, 9), CollisionMask.THING, alias)
    connection.close()


@pytest.mark.parametrize("can_detect", [True, False])
def test_what_measures_distances_is_found_out_and_said(simulator: Simulator, port: int, *, can_detect: bool) -> None:
    simulator.can_detect = can_detect
    with opened(port) as robot:
        is_fan = isinstance(simulator.graph.find("/rover/nose"), VisionSensor)
        distance = robot.range.read().distance
    assert is_fan is not can_detect
    assert robot.notes == (
        ("nose measures by a proximity sensor",)
        if can_detect
        else ("nose measures by pictures of depth; there are no proximity sensors",)
    )
    assert distance == pytest.approx(0.461, abs=0.01)


def test_where_nothing_measures_distances_no_way_is_called_free(
    simulator: Simulator, port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    simulator.can_detect = False
    monkeypatch.setattr(simulator, "handle", lambda _sensor: None)  # as where nothing can be drawn
    before = snapshot(simulator)
    with pytest.raises(BackendError, match=r"measures no distances: .* sees it 0\.90 m away, which is 0\.45 m"):
        opened(port)
    assert snapshot(simulator) == before


def test_bullet_computes_the_physics_meanwhile(port: int) -> None:
    mujoco = 4
    looking = Connection.open(Address(port=port), 5.0)
    engine = looking.constant("intparam_dynamic_engine")
    looking.sim("setInt32Param", engine, mujoco)
    with opened(port):
        assert looking.sim("getInt32Param", engine) == looking.constant("physics_bullet")
    assert looking.sim("getInt32Param", engine) == mujoco
    looking.close()


def test_cycle_takes_as_few_calls_as_the_api_allows(port: int, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    ask = Client.ask

    def noted(self: Client, name: str, *rest: Any) -> Any:
        if "Named" not in name:  # the lease's renewal comes when it comes
            asked.append(name)
        return ask(self, name, *rest)

    monkeypatch.setattr(Client, "ask", noted)
    with opened(port) as robot:
        for tick in (1, 2):  # in the first it is found out how sensors are handled
            asked.clear()
            robot["left_motor"].set_velocity(tick)
            robot["right_motor"].set_velocity(tick)
            robot.range.read()
            robot.camera.read()
            robot.clock.sleep_until(tick / 20)
            cycle = [name.removeprefix("sim.") for name in asked]
    assert cycle == [
        "handleProximitySensor",
        *("handleVisionSensor", "getVisionSensorImg"),
        *("setJointTargetVelocity", "setJointTargetVelocity"),
        *("step", "getSimulationTime", "getContactInfo"),
    ]


def test_robot_that_is_built_is_looked_for_in_no_scene() -> None:
    setup = Setup(load_robot("rover"), None, frozenset(), options={"port": 1})
    with pytest.raises(UsageError, match=r"'rover' has no section \[coppeliasim\], so it is built"):
        list(CoppeliaSimBackend().inspect_scene(setup))


def test_scene_that_is_somebodys_is_reported_with_robots_that_join_one() -> None:
    with (
        Double(bubblerob_scene()) as double,
        pytest.raises(BackendError, match=r"as bubblerob and lookout"),
    ):
        CoppeliaSimBackend().open(setup_on(double.zmq_port))
