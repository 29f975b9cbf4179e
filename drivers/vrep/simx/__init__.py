"""The functions and constants of V-REP's official Python binding, in pure Python.

A script for the official binding needs one changed line: ``import vrep`` becomes
``from drivers.vrep import simx as vrep``, and ``import sim`` becomes ``from drivers.vrep import simx as sim``. The
functions have the parameters and results of the official ones. They return the same error codes, even without a server.

Each client has a thread that exchanges messages until `simxFinish` ends it, as in the official binding. There is one
difference: after the connection is lost for good, calls return code 3 at once instead of after their time-out.

>>> from drivers.vrep import simx as vrep
>>> vrep.simxGetJointPosition(0, 17, vrep.simx_opmode_blocking)  # no client 0: code 64
(64, 0.0)
"""

from __future__ import annotations

from typing import NoReturn

from drivers.vrep.simx.clients import *  # noqa: F403
from drivers.vrep.simx.constants import *  # noqa: F403
from drivers.vrep.simx.objects import *  # noqa: F403
from drivers.vrep.simx.sensors_signals import *  # noqa: F403

__all__ = [name for name in dir() if name.startswith(("simx", "sim_"))]


def __getattr__(name: str) -> NoReturn:
    if name.startswith(("simx", "sim_")):
        raise AttributeError(
            f"drivers.vrep.simx has no {name}. If you have the official binding, name its folder with --option "
            "binding=PATH, or import it instead"
        )
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
