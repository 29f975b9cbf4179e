"""CoppeliaSim over its ZeroMQ remote API: a simulator that runs by itself, here or elsewhere."""

from __future__ import annotations

from contextlib import ExitStack

from pydantic import Field, PositiveFloat

from drivers.coppeliasim.connection import Address, Connection
from drivers.coppeliasim.lease import Lease
from drivers.coppeliasim.simulation import Simulation, make_room
from robotcore.backend import Backend, Setup, Vouch
from robotcore.description import Described
from robotcore.devices import Device
from robotcore.errors import DeviceError, DeviceGroupError, UsageError
from robotcore.robot import Robot

ANSWERING = 0.9
"""So much of the robot's ``safety.answer_s`` a call may take: who knows why nothing comes is to speak first."""


class CoppeliaSimOptions(Described):
    """Where CoppeliaSim listens, and how long it may take to answer."""

    host: str = "127.0.0.1"
    port: int = Field(default=23000, ge=1, le=65535)
    answer_s: PositiveFloat | None = None

    @property
    def address(self) -> Address:
        return Address(host=self.host, port=self.port)


class CoppeliaSimBackend(Backend):
    """Opens each robot in a CoppeliaSim that is running.

    Options: see `CoppeliaSimOptions`.
    """

    name = "coppeliasim"
    summary = "CoppeliaSim 4.6 and newer, over its ZeroMQ remote API"
    vouches_for = frozenset({Vouch.CONTACTS, Vouch.POSE, Vouch.LOCKSTEP})
    needs_world = True
    has_physics = True
    modules = ("coppeliasim_zmqremoteapi_client", "zmq")

    @property
    def remedy(self) -> str:
        return 'pip install "robotcore[coppeliasim]"'

    def open(self, setup: Setup) -> Robot:
        options = setup.options_as(CoppeliaSimOptions)
        self.require_installed()
        if setup.world is None:
            raise UsageError("the coppeliasim backend needs a world; name one with --world")
        answer_s = options.answer_s or ANSWERING * setup.robot.safety.answer_s
        with ExitStack() as undo:
            connection = Connection.open(options.address, answer_s)
            undo.callback(connection.close)
            lease = Lease(connection)
            lease.take()
            undo.callback(lease.release)
            make_room(connection)
            simulation = Simulation(connection, setup, setup.world)
            undo.callback(simulation.close)
            simulation.start()
            devices = _open_devices(simulation, setup)
            release = undo.pop_all().close
        return Robot(setup.robot.name, simulation.clock, devices, truth=simulation.truth, release=release)


def _open_devices(simulation: Simulation, setup: Setup) -> list[Device]:
    """Open every device that was chosen; raise DeviceGroupError with all that failed."""
    devices, failures = [], []
    for description in setup.chosen:
        try:
            devices.append(simulation.open(description))
        except DeviceError as failure:  # noqa: PERF203  every device that fails is to be named
            failures.append(failure)
    if failures:
        raise DeviceGroupError(f"opening {setup.robot.name}", failures)
    return devices
