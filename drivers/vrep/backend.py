"""The V-REP backend, which opens robots of an existing scene of V-REP or CoppeliaSim."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import closing
from functools import partial
from typing import Any

from pydantic import Field

from robotcore.description import RobotDescription
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.check_finding import Finding
from robotcore.hal.robot import Robot
from robotcore.simulation.remote_scene import (
    Scene,
    SceneOptions,
    inspect_scene,
    list_scene_devices,
    open_in_scene,
    read_bindings,
    warn_of_missing_kinds,
)
from robotcore.text import pluralize

SECTION = "vrep"
"""The section of a robot's file that binds devices to scene objects."""

SERVICE_PORT = 19999
"""The usual port of a server that a script of a running scene has started.

The simulation of such a scene runs without lockstep.
"""


class VrepOptions(SceneOptions):
    """The options of the V-REP backend.

    >>> VrepOptions().is_stepped, VrepOptions(port=19999).is_stepped
    (True, False)
    """

    port: int = Field(default=19997, ge=1, le=65535)
    stepped: bool | None = None
    """Whether to use lockstep. None stands for lockstep on all ports except 19999."""

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

    def openable(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        return list_scene_devices(robot)

    def warnings(self, robot: RobotDescription) -> list[str]:
        return warn_of_missing_kinds(robot)

    def inspect_scene(self, setup: Setup) -> Iterator[Finding]:
        options = setup.options_as(VrepOptions)
        read_bindings(setup.robot, SECTION)  # reports mistakes of the file before it connects
        with closing(_connect(options, setup)) as scene:
            yield from inspect_scene(setup.robot, SECTION, scene)

    def open(self, setup: Setup) -> Robot:
        options = setup.options_as(VrepOptions)
        return open_in_scene(
            setup,
            SECTION,
            partial(_connect, options, setup),
            options.simulation,
            is_stepped=options.is_stepped,
            cutoffs=partial(options.list_cutoffs, "drivers.vrep.cutoff:StopJoints", is_stepped=options.is_stepped),
        )


def _connect(options: VrepOptions, setup: Setup) -> Scene:
    from drivers.vrep.connection import Connection
    from drivers.vrep.scene import SteppedScene, StreamedScene

    connection = Connection.open(options.host, options.port, options.choose_answer_s(setup))
    return SteppedScene(connection) if options.is_stepped else StreamedScene(connection)
