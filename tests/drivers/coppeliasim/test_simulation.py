"""Tests of built scenes, and of restoring the user's scene."""

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
from drivers.coppeliasim.connection import SimulatorConnection
from drivers.coppeliasim.restore import begin_building
from robotcore.description import load_robot, load_world
from robotcore.errors import BackendError, DeviceError, DeviceGroupError, UsageError
from robotcore.hal.backend import Setup
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scene.objects import Lamp, Shape, VisionSensor
from tests.doubles.coppeliasim.scenes import default_scene
from tests.texts import CheckText, Raises

FLOOR = "/ResizableFloor_5_25"


@pytest.fixture
def simulator() -> Simulator:
    return default_scene()


@pytest.fixture
def port(simulator: Simulator) -> Iterator[int]:
    with Double(simulator) as double:
        yield double.zmq_port


def create_setup(port: int, world: str = "arena", **options: Any) -> Setup:
    robot = load_robot("rover")
    names = frozenset(device.name for device in robot.devices)
    return Setup(robot, load_world(world), names, options={"port": port, **options})


def open_robot(port: int, **options: Any) -> Any:
    return CoppeliaSimBackend().open(create_setup(port, **options))


def take_snapshot(simulator: Simulator) -> dict[str, Any]:
    with simulator.lock:
        nodes = {node.alias: simulator.graph.pose(node) for node in simulator.graph}
        return {"nodes": nodes, "step": simulator.time_step}


def test_scene_is_restored(simulator: Simulator, port: int) -> None:
    before = take_snapshot(simulator)
    with open_robot(port) as robot:
        robot.clock.sleep_until(0.2)
        paths = ["/rover/left_motor", "/rover/nose", "/rover/eye", "/rover/screen", "/arena/ball"]
        assert all(simulator.graph.find(path) for path in paths)
    assert take_snapshot(simulator) == before
    assert not simulator.graph.collections


def test_time_step_of_the_physics_is_set_and_restored(port: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.doubles.coppeliasim.zmq.functions.PHYSICS_STEP_S", 0.02)
    steps: list[float] = []
    call_within = Client.call_within

    def call_and_record(self: Client, name: str, arguments: Any, *rest: Any) -> Any:
        if (name, arguments[:1]) == ("sim.setFloatParam", (5,)):  # floatparam_physicstimestep
            steps.append(arguments[1])
        return call_within(self, name, arguments, *rest)

    monkeypatch.setattr(Client, "call_within", call_and_record)
    open_robot(port).close()
    assert steps == [0.005, 0.02]


def test_sensors_of_a_kept_scene_have_no_explicit_handling(simulator: Simulator, port: int) -> None:
    open_robot(port, keep=True).close()
    eye = simulator.graph.find("/rover/eye")
    assert isinstance(eye, VisionSensor)
    assert not eye.explicit


def test_option_keep_is_refused_for_a_joined_scene(raises: Raises) -> None:
    setup = Setup(load_robot("bubblerob"), None, frozenset(), options={"keep": "true"})
    with raises(UsageError, "nothing-to-keep"):
        CoppeliaSimBackend().open(setup)


@pytest.mark.slow
def test_kept_scene_that_was_loaded_with_new_handles_is_removed(simulator: Simulator, port: int) -> None:
    before = take_snapshot(simulator)
    open_robot(port, keep=True).close()
    with simulator.lock:
        nodes, simulator.graph._nodes = list(simulator.graph), {}
        for handle, node in enumerate(reversed(nodes), 100):
            node.handle = handle
            simulator.graph._nodes[handle] = node
    collections = dict(simulator.graph.collections)  # may be the user's
    open_robot(port).close()
    after = take_snapshot(simulator)
    assert after == before
    assert simulator.graph.collections == collections


def test_floor_and_lamps_of_the_scene_are_replaced(simulator: Simulator, port: int) -> None:
    with open_robot(port):
        floor = simulator.graph.find(FLOOR)
        assert floor
        assert simulator.graph.pose(floor).position[2] == pytest.approx(-0.5)
        sun = simulator.graph.all_of(Lamp)[0]
        down = np.array(simulator.graph.pose(sun).axes[2])
        assert -down == pytest.approx(load_world("arena").light.direction)


def test_scene_with_other_objects_is_refused(simulator: Simulator, port: int, raises: Raises) -> None:
    simulator.graph.add(Shape("Table"))
    with raises(BackendError, "scene-not-empty", paths=["/Table"]):
        open_robot(port)
    assert simulator.graph.find("/Table")
    assert not simulator.graph.find("/rover")


def test_running_simulation_is_refused_and_not_stopped(simulator: Simulator, port: int, raises: Raises) -> None:
    with simulator.lock:
        simulator.start()
    with raises(BackendError, "simulation-in-use", hide=[port], state="running"):
        open_robot(port)
    assert simulator.state.is_advancing


def test_built_objects_are_removed_if_opening_fails(simulator: Simulator, port: int, raises: Raises) -> None:
    before = take_snapshot(simulator)
    setup = create_setup(port)
    drive = setup.robot.drive
    assert drive
    loose = drive.model_copy(update={"left_encoder": None, "right_encoder": None})
    with raises(DeviceGroupError) as caught:
        CoppeliaSimBackend().open(replace(setup, robot=setup.robot.model_copy(update={"drive": loose})))
    assert {failure.kind for failure in caught.value.failures if isinstance(failure, DeviceError)} == {"no-wheel"}
    assert take_snapshot(simulator) == before


@pytest.mark.parametrize("last", [10, 40, 130])
def test_built_objects_are_removed_after_ctrl_c_in_a_call(
    simulator: Simulator, port: int, monkeypatch: pytest.MonkeyPatch, last: int
) -> None:
    before = take_snapshot(simulator)
    call, left = SimulatorConnection.call, last

    def call_and_interrupt(self: SimulatorConnection, *arguments: Any, **options: Any) -> Any:
        nonlocal left
        left -= 1
        answer = call(self, *arguments, **options)
        if left == 0:  # the answer is lost
            raise KeyboardInterrupt
        return answer

    monkeypatch.setattr(SimulatorConnection, "call", call_and_interrupt)
    with pytest.raises(KeyboardInterrupt):
        open_robot(port)
    assert take_snapshot(simulator) == before


@pytest.mark.slow
def test_next_program_removes_an_unmarked_object_of_a_killed_one(simulator: Simulator, port: int) -> None:
    before = take_snapshot(simulator)
    interrupt_building(port, "Sphere")
    open_robot(port).close()
    assert take_snapshot(simulator) == before


def test_objects_added_after_a_program_was_killed_stay(simulator: Simulator, port: int, raises: Raises) -> None:
    interrupt_building(port, "Sphere", "Table")
    with raises(BackendError, "scene-not-empty", paths=["/Sphere", "/Table"]):
        open_robot(port)
    assert simulator.graph.find("/Table")


def interrupt_building(port: int, *aliases: str) -> None:
    """Create these objects without a parent, as a program does that is killed while it builds a scene."""
    connection = SimulatorConnection.open(Address(port=port), 5.0)
    builder = SceneBuilder(connection)
    root = builder.create_dummy("arena")
    builder.write_note(root, NO_UNDO)
    begin_building(builder, root)
    for alias in aliases:
        builder.create_shape("spheroid", (0.1,) * 3, Placement(0.0, 0.0, 1.0), (9, 9, 9), CollisionMask.THING, alias)
    connection.close()


@pytest.mark.parametrize("can_detect", [True, False])
def test_note_says_how_range_sensors_measure(
    simulator: Simulator, port: int, check_text: CheckText, *, can_detect: bool
) -> None:
    simulator.can_detect = can_detect
    with open_robot(port) as robot:
        is_fan = isinstance(simulator.graph.find("/rover/nose"), VisionSensor)
        distance = robot.range.read().distance
    assert is_fan is not can_detect
    check_text("\n".join(robot.notes))
    assert distance == pytest.approx(0.461, abs=0.01)


def test_simulator_that_cannot_measure_distances_is_refused(
    simulator: Simulator, port: int, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    simulator.can_detect = False
    monkeypatch.setattr(simulator, "handle", lambda _sensor: None)  # as without graphics
    before = take_snapshot(simulator)
    with raises(BackendError, "no-distances", hide=[port]):
        open_robot(port)
    assert take_snapshot(simulator) == before


@pytest.mark.slow
def test_bullet_is_selected_during_a_run(port: int) -> None:
    mujoco = 4
    connection = SimulatorConnection.open(Address(port=port), 5.0)
    engine = connection.constant("intparam_dynamic_engine")
    connection.sim("setInt32Param", engine, mujoco)
    with open_robot(port):
        assert connection.sim("getInt32Param", engine) == connection.constant("physics_bullet")
    assert connection.sim("getInt32Param", engine) == mujoco
    connection.close()


def test_cycle_needs_eight_calls(port: int, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[str] = []
    call_within = Client.call_within

    def call_and_record(self: Client, name: str, *rest: Any) -> Any:
        if "Named" not in name:  # the lock is renewed at any time
            calls.append(name)
        return call_within(self, name, *rest)

    monkeypatch.setattr(Client, "call_within", call_and_record)
    with open_robot(port) as robot:
        for tick in (1, 2):  # the first cycle reads how sensors are handled
            calls.clear()
            robot["left_motor"].set_velocity(tick)
            robot["right_motor"].set_velocity(tick)
            robot.range.read()
            robot.camera.read()
            robot.clock.sleep_until(tick / 20)
            cycle = [name.removeprefix("sim.") for name in calls]
    assert cycle == [
        "handleProximitySensor",
        *("handleVisionSensor", "getVisionSensorImg"),
        *("setJointTargetVelocity", "setJointTargetVelocity"),
        *("step", "getSimulationTime", "getContactInfo"),
    ]


def test_scene_of_a_built_robot_is_not_inspected(raises: Raises) -> None:
    setup = Setup(load_robot("rover"), None, frozenset(), options={"port": 1})
    with raises(UsageError, "nothing-to-inspect", robot="rover"):
        list(CoppeliaSimBackend().inspect_scene(setup))
