"""Who starts and stops a simulation that several may look at."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum

from robotcore.errors import BackendError
from robotcore.simulation.remote_scene.port import Scene, State


class Whose(str, Enum):
    """Whose business it is to start the simulation where it is stopped, and then to stop it again.

    One that is found running is left running either way.
    """

    OURS = "ours"
    THEIRS = "theirs"


@contextmanager
def running(scene: Scene, whose: Whose) -> Iterator[None]:
    """Let the simulation run meanwhile, and leave it as it was found.

    Raises BackendError where it is paused, or stopped and somebody else's to start.
    """
    state = scene.state()
    if state is State.PAUSED:
        raise BackendError("the simulation is paused. Let it go on there, or stop it, and run this again")
    if state is State.STOPPED and whose is Whose.THEIRS:
        raise BackendError(
            "the simulation is stopped, and with option simulation=theirs it is started by others. "
            "Start it there, or leave the option out"
        )
    try:
        scene.start()
        yield
    finally:
        if state is State.STOPPED:
            scene.stop()
