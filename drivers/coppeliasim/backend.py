"""The CoppeliaSim backend, its options, and its part of `robotcore doctor`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, closing
from functools import partial
from typing import Any

from pydantic import Field

from drivers.coppeliasim.address import Address
from drivers.coppeliasim.builder import SceneBuilder
from drivers.coppeliasim.connection import LOADING_S, SimulatorConnection
from drivers.coppeliasim.scene import CoppeliaSimScene
from drivers.coppeliasim.sensors import do_proximity_sensors_work
from drivers.coppeliasim.simulation import Simulation, build_scene, clear_scene, leave_scene
from drivers.coppeliasim.simulator_lock import SimulatorLock
from robotcore.description import RobotDescription, WorldDescription
from robotcore.errors import BackendError, UsageError
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.check_finding import Finding
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.robot import Robot
from robotcore.simulation.remote_scene import (
    SceneOptions,
    SimulationControl,
    State,
    inspect_scene,
    list_scene_devices,
    open_in_scene,
    read_bindings,
    require_scene_devices,
    warn_of_missing_kinds,
)
from robotcore.text import pluralize

SECTION = "coppeliasim"
"""The section of a robot's file that binds devices to scene objects."""


class CoppeliaSimOptions(SceneOptions):
    """The options of the CoppeliaSim backend.

    >>> CoppeliaSimOptions(port=23010).simulation.value
    'program'
    """

    port: int = Field(default=23000, ge=1, le=65535)
    keep: bool = False
    """Whether the built robot and world stay in CoppeliaSim after the run. By default the backend removes them."""

    @property
    def address(self) -> Address:
        return Address(host=self.host, port=self.port)


class CoppeliaSimBackend(Backend):
    """Opens robots in a running CoppeliaSim. Its options are `CoppeliaSimOptions`.

    If the robot's file has a section ``[coppeliasim]``, the backend uses the robot of the scene that is open in
    CoppeliaSim. Otherwise the backend builds the robot and the world.

    >>> from robotcore.description import load_robot
    >>> backend = CoppeliaSimBackend()
    >>> backend.builds_world(load_robot("rover")), backend.builds_world(load_robot("bubblerob"))
    (True, False)
    """

    name = "coppeliasim"
    summary = "CoppeliaSim 4.6 and newer, over its ZeroMQ remote API"
    capabilities = frozenset({Capability.CONTACTS, Capability.POSE, Capability.LOCKSTEP})
    needs_world = True
    is_exclusive = True
    modules = ("coppeliasim_zmqremoteapi_client", "zmq")

    @property
    def remedy(self) -> str:
        return 'pip install "robotcore[coppeliasim]"'

    def builds_world(self, robot: RobotDescription) -> bool:
        return SECTION not in robot.backends

    def check(self, robot: RobotDescription) -> str:
        if self.builds_world(robot):
            return ""
        bound = read_bindings(robot, SECTION)
        return pluralize(len(bound), "object")

    def openable(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        return list_scene_devices(robot)

    def warnings(self, robot: RobotDescription) -> list[str]:
        return warn_of_missing_kinds(robot)

    def inspect_scene(self, setup: Setup) -> Iterator[Finding]:
        options = setup.options_as(CoppeliaSimOptions)
        if self.builds_world(setup.robot):
            raise UsageError(
                f"the robot {setup.robot.name!r} has no section [{SECTION}]. So each run builds it, and the scene has "
                f"nothing to check. Omit --backend, or add [{SECTION}.DEVICE] with path for each device in the scene",
                kind="nothing-to-inspect",
                robot=setup.robot.name,
            )
        read_bindings(setup.robot, SECTION)  # reports mistakes of the file before it connects
        self.require_installed()
        with closing(_create_scene(SimulatorConnection.open(options.address, options.choose_answer_s(setup)))) as scene:
            yield from inspect_scene(setup.robot, SECTION, scene)

    def examine(self, robot: RobotDescription | None) -> Iterator[Finding]:
        yield from diagnose(Address())

    def open(self, setup: Setup) -> Robot:
        options = setup.options_as(CoppeliaSimOptions)
        self.require_installed()
        may_stop = self.builds_world(setup.robot) or options.simulation is SimulationControl.PROGRAM
        connect = partial(open_scene, options.address, options.choose_answer_s(setup), may_stop=may_stop)
        cutoffs = partial(options.list_cutoffs, "drivers.coppeliasim.cutoff:StopJoints")
        if not self.builds_world(setup.robot):
            if options.keep:
                raise UsageError(
                    "option keep is for robots that the backend builds, but this robot is in the open scene. Omit the "
                    "option",
                    kind="nothing-to-keep",
                )
            return open_in_scene(setup, SECTION, connect, options.simulation, cutoffs=cutoffs)
        if setup.world is None:
            raise UsageError("the coppeliasim backend needs a world. Name one with --world", kind="missing-world")
        return _open_built(setup, setup.world, connect, cutoffs, keep=options.keep)


def _open_built(
    setup: Setup,
    world: WorldDescription,
    connect: Callable[[], CoppeliaSimScene],
    cutoffs: Callable[[Mapping[str, int]], Iterable[CutoffSpec]],
    *,
    keep: bool,
) -> Robot:
    require_scene_devices(setup)
    with ExitStack() as undo:
        scene = connect()
        undo.callback(scene.close)
        builder = SceneBuilder(scene.connection)
        clear_scene(scene, builder)
        undo.callback(leave_scene, scene, builder, keep=keep)
        simulation = Simulation(scene, setup, build_scene(scene, builder, setup, world))
        simulation.start()
        devices = setup.open_each(simulation.open)
        release = undo.pop_all().close
    return Robot(
        setup.robot.name,
        simulation.clock,
        devices,
        truth=simulation.truth,
        release=release,
        notes=simulation.notes,
        cutoffs=cutoffs(simulation.motor_joints),
    )


def open_scene(address: Address, answer_s: float, *, may_stop: bool) -> CoppeliaSimScene:
    """Connect to a simulator, acquire its lock, and return its scene.

    answer_s: time limit of a call, in seconds.
    may_stop: whether to stop a simulation that runs because the previous program was killed.

    Raises BackendError if no server answers, or if another program holds the lock.
    """
    with ExitStack() as undo:
        connection = SimulatorConnection.open(address, answer_s)
        undo.callback(connection.close)
        lock = SimulatorLock(connection)
        scene = _create_scene(connection, lock)
        undo.callback(scene.close)
        if lock.acquire() and may_stop and scene.read_state() is not State.STOPPED:
            scene.stop()
        undo.pop_all()
    return scene


def _create_scene(connection: SimulatorConnection, lock: SimulatorLock | None = None) -> CoppeliaSimScene:
    return CoppeliaSimScene(connection, lock, partial(do_proximity_sensors_work, SceneBuilder(connection)))


_NAME = "coppeliasim"
_ENGINES = {0: "Bullet", 1: "ODE", 2: "Vortex", 3: "Newton", 4: "MuJoCo", 5: "Drake"}


def diagnose(address: Address) -> Iterator[Finding]:
    """Yield findings for `robotcore doctor` about a CoppeliaSim: its version, physics engine and proximity sensors."""
    try:
        with closing(CoppeliaSimScene(SimulatorConnection.open(address, LOADING_S))) as scene:
            yield from _diagnose_scene(scene)
    except BackendError as error:
        problem, _, remedy = str(error).removeprefix(f"{_NAME}: ").partition(". ")
        note = f". These are options of robotcore run and check: the doctor checks {address} only"
        yield Finding.warning(_NAME, problem, remedy + note * ("--port" in remedy), kind=error.kind)


def _diagnose_scene(scene: CoppeliaSimScene) -> Iterator[Finding]:
    connection = scene.connection
    version = connection.call_as(int, "getInt32Param", connection.constant("intparam_program_full_version"))
    yield Finding.ok(_NAME, f"version {_format_version(version)} answers at {connection.address}", kind="version")
    engine = connection.call_as(int, "getInt32Param", connection.constant("intparam_dynamic_engine"))
    yield Finding.ok("physics", f"by {_ENGINES.get(engine, engine)}", kind="engine")
    if scene.read_state() is not State.STOPPED:
        yield Finding.warning(
            "proximity sensors",
            "were not tested, because a simulation runs",
            "Stop the simulation, and run the doctor again",
            kind="simulation-running",
        )
    elif do_proximity_sensors_work(SceneBuilder(connection), scene.detect):
        yield Finding.ok("proximity sensors", "detect a box in front of them", kind="sensors-work")
    else:
        yield Finding.warning(
            "proximity sensors",
            "do not work. A robot that robotcore builds measures distances with depth pictures instead, and a robot of "
            "an open scene cannot be opened with these sensors",
            "Install a CoppeliaSim that has the plug-in for proximity sensors",
            kind="no-sensors",
        )


def _format_version(number: int) -> str:
    """Format CoppeliaSim's version number, such as 4100000 for 4.10.0. The last two digits are the revision."""
    return f"{number // 1000000}.{number // 10000 % 100}.{number // 100 % 100}"
