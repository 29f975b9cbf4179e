"""The V-REP backend, which opens robots of an existing scene of V-REP or CoppeliaSim."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import closing
from functools import partial

from pydantic import Field

from robotcore.description import RobotDescription, StrictModel
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.check_finding import Finding
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.robot import Robot
from robotcore.simulation.remote_scene import Scene, SimulationControl, inspect_scene, open_in_scene, read_bindings
from robotcore.text import pluralize

SECTION = "vrep"
"""The section of a robot's file that binds devices to scene objects."""

SERVICE_PORT = 19999
"""The usual port of a server that a script of a running scene has started.

The simulation of such a scene runs without lockstep.
"""

ANSWER_SHARE = 0.9
"""The default time limit of a call, as a share of the robot's ``safety.answer_s``.

It is less than 1, so that this driver reports a late answer before the watchdog does. The driver's message has more
details than the watchdog's.
"""

GUARDIAN_PATIENCE_S = 60.0
"""The time by which the guardian extends its lease in lockstep, in seconds.

It is long, because no wheel turns in the meantime. In lockstep, the simulation waits for the program.
"""


class VrepOptions(StrictModel):
    """The options of the V-REP backend.

    >>> VrepOptions().is_stepped, VrepOptions(port=19999).is_stepped
    (True, False)
    """

    host: str = "127.0.0.1"
    port: int = Field(default=19997, ge=1, le=65535)
    stepped: bool | None = None
    """Whether to use lockstep. None stands for lockstep on all ports except 19999."""
    simulation: SimulationControl = SimulationControl.OURS
    """Whether this program or the user starts and stops the simulation."""
    answer_s: float | None = Field(default=None, gt=0, le=3600)
    """Time limit of a call, in seconds; None stands for `ANSWER_SHARE` of ``safety.answer_s``."""

    @property
    def is_stepped(self) -> bool:
        """Whether to use lockstep, in which the simulation waits for this program before each time step."""
        return self.port != SERVICE_PORT if self.stepped is None else self.stepped


class VrepBackend(Backend):
    """Opens robots of the scene that is open in V-REP or CoppeliaSim. Its options are `VrepOptions`.

    It uses the legacy remote API, and needs no files of the simulator.

    >>> from robotcore.description import load_robot
    >>> VrepBackend().check(load_robot("rover"))
    '7 objects'
    """

    name = "vrep"
    summary = "V-REP's scenes, over the legacy remote API on 19997; no lockstep on port 19999"
    is_exclusive = True
    capabilities = frozenset({Capability.POSE, Capability.LOCKSTEP})

    def check(self, robot: RobotDescription) -> str:
        bound = read_bindings(robot, SECTION)
        return pluralize(len(bound), "object")

    def inspect_scene(self, setup: Setup) -> Iterator[Finding]:
        options = setup.options_as(VrepOptions)
        read_bindings(setup.robot, SECTION)  # reports mistakes of the file before it connects
        with closing(_connect(options, _choose_answer_s(options, setup))) as scene:
            yield from inspect_scene(setup.robot, SECTION, scene)

    def open(self, setup: Setup) -> Robot:
        options, setup = setup.options_as(VrepOptions), setup.without_batteries()
        answer_s = _choose_answer_s(options, setup)
        connect = partial(_connect, options, answer_s)
        cutoffs = partial(_list_cutoffs, options)
        return open_in_scene(
            setup, SECTION, connect, options.simulation, is_stepped=options.is_stepped, cutoffs=cutoffs
        )


def _choose_answer_s(options: VrepOptions, setup: Setup) -> float:
    return options.answer_s or ANSWER_SHARE * setup.robot.safety.answer_s


def _connect(options: VrepOptions, answer_s: float) -> Scene:
    from drivers.vrep.connection import Connection
    from drivers.vrep.scene import SteppedScene, StreamedScene

    connection = Connection.open(options.host, options.port, answer_s)
    return SteppedScene(connection) if options.is_stepped else StreamedScene(connection)


def _list_cutoffs(options: VrepOptions, joints: Mapping[str, int]) -> Iterator[CutoffSpec]:
    """Yield the cutoff with which the guardian stops the wheels if this process cannot stop them.

    One cutoff stops all wheels, because a port serves one connection at a time.
    """
    if joints:
        arguments = {"host": options.host, "port": options.port, "joints": list(joints.values())}
        patience_s = GUARDIAN_PATIENCE_S if options.is_stepped else 0.0
        yield CutoffSpec(" and ".join(joints), "drivers.vrep.cutoff:StopJoints", arguments, patience_s)
