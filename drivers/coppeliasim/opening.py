"""A CoppeliaSim's scene, opened for one program alone."""

from __future__ import annotations

from contextlib import ExitStack

from drivers.coppeliasim.address import Address
from drivers.coppeliasim.connection import Connection
from drivers.coppeliasim.lease import Lease
from drivers.coppeliasim.scene import CoppeliaSimScene
from robotcore.simulation.remote_scene import State


def open_scene(address: Address, answer_s: float, *, may_stop: bool) -> CoppeliaSimScene:
    """Connect, keep others out, and recover the simulation from a program that was killed, where we ``may_stop`` it.

    Raises BackendError where nobody answers, or another program drives this CoppeliaSim.
    """
    with ExitStack() as undo:
        connection = Connection.open(address, answer_s)
        undo.callback(connection.close)
        lease = Lease(connection)
        scene = CoppeliaSimScene(connection, lease)
        undo.callback(scene.close)
        if lease.take() and may_stop and scene.state() is not State.STOPPED:
            scene.stop()
        undo.pop_all()
    return scene
