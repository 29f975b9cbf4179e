"""CoppeliaSim over its ZeroMQ remote API: a simulator that runs by itself, here or elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, closing
from functools import partial

from pydantic import Field, PositiveFloat

from drivers.coppeliasim.address import Address
from drivers.coppeliasim.builder import SceneBuilder
from drivers.coppeliasim.connection import LOADING_S, Connection
from drivers.coppeliasim.lease import Lease
from drivers.coppeliasim.scene import CoppeliaSimScene
from drivers.coppeliasim.sensors import proximity_works
from drivers.coppeliasim.simulation import Simulation, build_scene, clear_scene, leave_scene
from robotcore.description import RobotDescription, StrictModel, WorldDescription
from robotcore.errors import BackendError, UsageError
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.finding import Finding
from robotcore.hal.robot import Robot
from robotcore.simulation.remote_scene import Owner, State, inspect_scene, open_in_scene, read_bindings
from robotcore.text import pluralize

SECTION = "coppeliasim"
"""Where a robot's file says which object each device is."""

ANSWERING = 0.9
"""So much of the robot's ``safety.answer_s`` a call may take: who knows why nothing comes is to speak first."""


STEPPED_S = 60.0
"""While a program lives the simulation waits for it, however long: only one that is gone leaves wheels turning."""


class CoppeliaSimOptions(StrictModel):
    """Where CoppeliaSim listens, and how long it may take to answer, ``answer_s``.

    Of a scene that is built: whether to ``keep`` it at the end, to be looked at. Of one that is joined: whose business
    it is to start the ``simulation``, ours or theirs.
    """

    host: str = "127.0.0.1"
    port: int = Field(default=23000, ge=1, le=65535)
    answer_s: PositiveFloat | None = None
    keep: bool = False
    simulation: Owner = Owner.OURS

    @property
    def address(self) -> Address:
        return Address(host=self.host, port=self.port)


class CoppeliaSimBackend(Backend):
    """Opens robots in a CoppeliaSim that is running: in its scene, or in one that is built there.

    A robot whose file has a section ``[coppeliasim]`` is there already. Options: see `CoppeliaSimOptions`.
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

    def inspect_scene(self, setup: Setup) -> Iterator[Finding]:
        options = setup.options_as(CoppeliaSimOptions)
        if self.builds_world(setup.robot):
            raise UsageError(
                f"the robot {setup.robot.name!r} has no section [{SECTION}], so it is built when it is run, and "
                f"nothing is looked for in the scene. Leave --backend out, or add [{SECTION}.DEVICE] with path for "
                "each device that is in the scene"
            )
        read_bindings(setup.robot, SECTION)  # what is wrong with a file is told before anybody is asked
        self.require_installed()
        with closing(_scene(Connection.open(options.address, _answer_s(options, setup)))) as scene:
            yield from inspect_scene(setup.robot, SECTION, scene)

    def examine(self, robot: RobotDescription | None) -> Iterator[Finding]:
        if not self.is_installed:
            yield Finding.warning(self.name, "is not installed", self.remedy)
        else:
            yield from diagnose(Address())

    def open(self, setup: Setup) -> Robot:
        options, setup = setup.options_as(CoppeliaSimOptions), setup.without_batteries()
        self.require_installed()
        may_stop = self.builds_world(setup.robot) or options.simulation is Owner.OURS
        connect = partial(open_scene, options.address, _answer_s(options, setup), may_stop=may_stop)
        cutoffs = partial(_cutoffs, options)
        if not self.builds_world(setup.robot):
            if options.keep:
                raise UsageError("option keep: the scene is somebody's and stays as it is; leave the option out")
            return open_in_scene(setup, SECTION, connect, options.simulation, cutoffs=cutoffs)
        if setup.world is None:
            raise UsageError("the coppeliasim backend needs a world; name one with --world")
        return _built(setup, setup.world, connect, cutoffs, keep=options.keep)


def _answer_s(options: CoppeliaSimOptions, setup: Setup) -> float:
    return options.answer_s or ANSWERING * setup.robot.safety.answer_s


def _cutoffs(options: CoppeliaSimOptions, joints: Mapping[str, int]) -> Iterator[CutoffSpec]:
    """Yield how the wheels in a scene come to stand if this process is killed: time goes on then."""
    if joints:
        where = {"host": options.host, "port": options.port, "joints": list(joints.values())}
        yield CutoffSpec(" and ".join(joints), "drivers.coppeliasim.cutoff:StopJoints", where, STEPPED_S)


def _built(
    setup: Setup,
    world: WorldDescription,
    connect: Callable[[], CoppeliaSimScene],
    cutoffs: Callable[[Mapping[str, int]], Iterable[CutoffSpec]],
    *,
    keep: bool,
) -> Robot:
    """Open a robot in a scene that is built for it; what was made by then is removed where that fails."""
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
        cutoffs=cutoffs(simulation.driven),
    )


def open_scene(address: Address, answer_s: float, *, may_stop: bool) -> CoppeliaSimScene:
    """Connect, keep others out, and recover the simulation from a program that was killed, where we ``may_stop`` it.

    Raises BackendError where nobody answers, or another program drives this CoppeliaSim.
    """
    with ExitStack() as undo:
        connection = Connection.open(address, answer_s)
        undo.callback(connection.close)
        lease = Lease(connection)
        scene = _scene(connection, lease)
        undo.callback(scene.close)
        if lease.take() and may_stop and scene.read_state() is not State.STOPPED:
            scene.stop()
        undo.pop_all()
    return scene


def _scene(connection: Connection, lease: Lease | None = None) -> CoppeliaSimScene:
    return CoppeliaSimScene(connection, lease, partial(proximity_works, SceneBuilder(connection)))


_NAME = "coppeliasim"
_ENGINES = {0: "Bullet", 1: "ODE", 2: "Vortex", 3: "Newton", 4: "MuJoCo", 5: "Drake"}


def diagnose(address: Address) -> Iterator[Finding]:
    """Yield which CoppeliaSim answers, what computes its physics, and whether it has proximity sensors."""
    try:
        with closing(CoppeliaSimScene(Connection.open(address, LOADING_S))) as scene:
            yield from _diagnose_scene(scene)
    except BackendError as error:
        said, _, remedy = str(error).removeprefix(f"{_NAME}: ").partition(". ")
        only = f". These are options of robotcore run and check: the doctor looks at {address} alone"
        yield Finding.warning(_NAME, said, remedy + only * ("--port" in remedy))


def _diagnose_scene(scene: CoppeliaSimScene) -> Iterator[Finding]:
    connection = scene.connection
    version = connection.call_as(int, "getInt32Param", connection.constant("intparam_program_full_version"))
    yield Finding.ok(_NAME, f"version {_version(version)} answers at {connection.address}")
    engine = connection.call_as(int, "getInt32Param", connection.constant("intparam_dynamic_engine"))
    yield Finding.ok("physics", f"by {_ENGINES.get(engine, engine)}")
    if scene.read_state() is not State.STOPPED:
        yield Finding.warning("proximity sensors", "not tried: a simulation is under way", "Stop it, and look again")
    elif proximity_works(SceneBuilder(connection), scene.detect):
        yield Finding.ok("proximity sensors", "detect what is in front of them")
    else:
        yield Finding.warning(
            "proximity sensors",
            "detect nothing: robots that are built measure by pictures of depth, others cannot be opened",
            "Install a CoppeliaSim with its plug-in for them, as the maker's downloads are",
        )


def _version(number: int) -> str:
    """Return 4.10.0 for 4100000: two digits each for the second, third and the revision."""
    return f"{number // 1000000}.{number // 10000 % 100}.{number // 100 % 100}"
