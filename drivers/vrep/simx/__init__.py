"""The official binding's functions and constants, in pure Python: scripts need one changed line.

``import vrep`` or ``import sim`` becomes ``from drivers.vrep import simx as vrep`` or ``… as sim``. The functions take
what the official ones take and return what they return: codes where those return codes, even without a server.

As there, each client has a thread that goes on exchanging messages until `simxFinish` ends it. Otherwise than there, a
client whose line is broken for good says so at once (code 3) instead of after its time-out.
"""

from __future__ import annotations

from typing import NoReturn

from drivers.vrep.simx.clients import *  # noqa: F403
from drivers.vrep.simx.constants import *  # noqa: F403
from drivers.vrep.simx.objects import *  # noqa: F403  # noqa: F403  # noqa: F403
from drivers.vrep.simx.sensors_signals import *  # noqa: F403  # noqa: F403

__all__ = [name for name in dir() if name.startswith(("simx", "sim_"))]


def __getattr__(name: str) -> NoReturn:
    if name.startswith(("simx", "sim_")):
        raise AttributeError(
            f"{name} is not among what this client knows of the legacy remote API. Where you have the official "
            "binding, give its folder: --option binding=PATH, or import it instead of drivers.vrep.simx"
        )
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
