"""The functions and constants of V-REP's official Python binding, in pure Python.

In a script for the official binding, one line must be changed: ``import vrep`` to
``from drivers.vrep import simx as vrep``, or ``import sim`` to ``from drivers.vrep import simx as sim``. The functions
have the parameters, the results and the return codes of the official ones.

Each client has a thread that exchanges messages until `simxFinish` ends it, as in the official binding. There is one
difference: once a connection is lost and is not opened again, calls return code 3 at once, not after their time-out.

>>> from drivers.vrep import simx as vrep
>>> vrep.simxGetJointPosition(0, 17, vrep.simx_opmode_blocking)  # no client 0: code 64
(64, 0.0)
"""

from __future__ import annotations

from typing import NoReturn

from drivers.vrep.simx.clients import *  # noqa: F403
from drivers.vrep.simx.commands import *  # noqa: F403
from drivers.vrep.simx.constants import *  # noqa: F403
from drivers.vrep.simx.sensors_signals import *  # noqa: F403

__all__ = [name for name in dir() if name.startswith(("simx", "sim_"))]


def __getattr__(name: str) -> NoReturn:
    if name.startswith(("simx", "sim_")):
        raise AttributeError(
            f"drivers.vrep.simx has no {name}. Import the official binding (vrep.py or sim.py) instead"
        )
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
