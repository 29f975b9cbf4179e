"""A CoppeliaSim's scene, opened for one program alone."""

from __future__ import annotations

from drivers.coppeliasim.connection import Address, Connection
from drivers.coppeliasim.lease import Lease
from drivers.coppeliasim.scene import CoppeliaSimScene
from robotcore.errors import BackendError
from robotcore.scene import State


def open_scene(address: Address, answer_s: float, *, may_stop: bool) -> CoppeliaSimScene:
    """Connect, keep others out, and recover the simulation from a program that was killed, where we ``may_stop`` it.

    Raises BackendError where nobody answers, or another program drives this CoppeliaSim.
    """
    connection = Connection.open(address, answer_s)
    lease = Lease(connection)
    scene = CoppeliaSimScene(connection, lease)
    try:
        if not lease.take():
            return scene
        if may_stop and scene.state() is not State.STOPPED:
            scene.stop()
    except BackendError:
        scene.close()
        raise
    return scene
