"""V-REP, and CoppeliaSim as long as it has it, over the legacy remote API: somebody's scene is joined."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import closing
from functools import partial

from pydantic import Field

from robotcore.description import RobotDescription, StrictModel
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.finding import Finding
from robotcore.hal.robot import Robot
from robotcore.simulation.remote_scene import Owner, Scene, inspect_scene, open_in_scene, read_bindings
from robotcore.text import pluralize

SECTION = "vrep"
"""Where a robot's file says which object each device is."""

SERVICE_PORT = 19999
"""Where scripts of a running scene serve, by custom: such a simulation goes on by itself."""

ANSWERING = 0.9
"""So much of the robot's ``safety.answer_s`` a call may take: who knows why nothing comes is to speak first."""

UNSTEPPED_S = 60.0
"""An app that steps may be silent for so long: its wheels stand when it does not step. They turn on if it dies."""


class VrepOptions(StrictModel):
    """Where the simulator listens; whether it is ``stepped`` (by default it is, but for the port 19999).

    ``simulation`` is whose business it is to start it: ours or theirs. ``answer_s`` is how long a call may take.
    ``binding`` is the folder of the official binding, where that is to be used instead of our own client.
    """

    host: str = "127.0.0.1"
    port: int = Field(default=19997, ge=1, le=65535)
    stepped: bool | None = None
    simulation: Owner = Owner.OURS
    answer_s: float | None = Field(default=None, gt=0, le=3600)
    binding: str | None = None

    @property
    def is_stepped(self) -> bool:
        return self.port != SERVICE_PORT if self.stepped is None else self.stepped


class VrepBackend(Backend):
    """Opens robots in the scene that a V-REP or CoppeliaSim has open; nothing is copied from an installation.

    Options: see `VrepOptions`.
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
        read_bindings(setup.robot, SECTION)  # what is wrong with a file is told before anybody is asked
        with closing(_connected(options, _answer_s(options, setup))) as scene:
            yield from inspect_scene(setup.robot, SECTION, scene)

    def open(self, setup: Setup) -> Robot:
        options, setup = setup.options_as(VrepOptions), setup.without_batteries()
        answer_s = _answer_s(options, setup)
        connect = partial(_connected, options, answer_s)
        cutoffs = partial(_cutoffs, options)
        return open_in_scene(
            setup, SECTION, connect, options.simulation, is_stepped=options.is_stepped, cutoffs=cutoffs
        )


def _answer_s(options: VrepOptions, setup: Setup) -> float:
    return options.answer_s or ANSWERING * setup.robot.safety.answer_s


def _connected(options: VrepOptions, answer_s: float) -> Scene:
    if options.binding is not None:
        from drivers.vrep.official_binding import Calls, load_binding
        from drivers.vrep.official_scene import OfficialScene

        calls = Calls(load_binding(options.binding), options.host, options.port, answer_s)
        return OfficialScene(calls, answer_s, is_stepped=options.is_stepped)
    if options.is_stepped:
        from drivers.vrep.connection import Connection
        from drivers.vrep.stepped import SteppedScene

        return SteppedScene(Connection.to(options.host, options.port, answer_s))
    from drivers.vrep.streaming import StreamedScene, StreamReader

    return StreamedScene(StreamReader.to(options.host, options.port, answer_s), answer_s)


def _cutoffs(options: VrepOptions, joints: Mapping[str, int]) -> Iterator[CutoffSpec]:
    """Yield how the wheels come to stand if this process cannot make them: all over the one line there is."""
    if joints:
        where = {"host": options.host, "port": options.port, "joints": list(joints.values())}
        patience_s = UNSTEPPED_S if options.is_stepped else 0.0
        yield CutoffSpec(" and ".join(joints), "drivers.vrep.cutoff:StopJoints", where, patience_s)
