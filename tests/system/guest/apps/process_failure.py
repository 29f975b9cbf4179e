"""An app that drives and then hangs or dies, for checks of the guardian."""

import ctypes
import os
import signal
import warnings
from dataclasses import dataclass

from robotcore import Behaviour, Robot, Role, Status

LONG_S = 3


@dataclass
class ProcessFailure(Behaviour):
    """Calls the method ``action`` in its tenth tick, and ends two ticks later."""

    needs = frozenset({Role.DRIVE})

    action: str = "hold"

    def __post_init__(self) -> None:
        self._ticks = 0

    def step(self, robot: Robot) -> Status:
        self._ticks += 1
        if self._ticks == 9 and self.action == "stop_and_hold":
            robot.drive.stop()
        if self._ticks == 10:
            getattr(self, f"_{self.action}")()
        if self._ticks < 9:
            robot.drive.set_velocity(0.2, 0.0)
        return Status.RUNNING if self._ticks < 12 else Status.SUCCESS

    def _hold(self) -> None:
        """Hold the interpreter lock, as a vendor's call may."""
        ctypes.PyDLL(None).sleep(LONG_S)

    _stop_and_hold = _hold

    def _fork_and_kill(self) -> None:
        """Fork a process that lives for a while, and kill this one."""
        warnings.simplefilter("ignore", DeprecationWarning)
        if os.fork() == 0:
            ctypes.CDLL(None).sleep(20)
            os._exit(0)
        os.kill(os.getpid(), signal.SIGKILL)
