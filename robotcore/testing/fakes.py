"""Test doubles for drivers: a gate that delays hardware calls, and a spy on an actuator's commands."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from robotcore.errors import DeviceError
from robotcore.hal.device import Actuator
from robotcore.kinds.motor import Motor

SETTLE_LIMIT_S = 5.0
"""A call that waits for a lock, instead of the gate, counts as blocked after this time, in seconds."""


class Gate:
    """A gate that delays the answers of fake hardware while it is shut.

    The fake hardware calls `pass_through` before each answer, also before it confirms a motor's command. `blocks`
    returns whether a call waits for an answer.

    >>> gate = Gate()
    >>> gate
    Gate(open)
    >>> gate.blocks(gate.pass_through)
    True
    >>> gate.blocks(lambda: None)
    False
    """

    def __init__(self) -> None:
        self._is_open = threading.Event()
        self._is_open.set()
        self._settled = threading.Event()
        self._caller: int | None = None

    def __repr__(self) -> str:
        return f"Gate({'open' if self._is_open.is_set() else 'shut'})"

    def pass_through(self) -> None:
        """Wait until the gate is open."""
        if threading.get_ident() == self._caller and not self._is_open.is_set():
            self._settled.set()
        self._is_open.wait()

    def blocks(self, call: Callable[[], object]) -> bool:
        """Call a function with the gate shut, open the gate, and return whether the call waited for it.

        Raises the exception of the call.
        """
        self._settled.clear()
        self._is_open.clear()
        with ThreadPoolExecutor(1, initializer=self._note_caller) as caller:
            result = caller.submit(call)
            result.add_done_callback(lambda _: self._settled.set())
            self._settled.wait(SETTLE_LIMIT_S)
            was_held = not result.done()
            self._is_open.set()
        result.result()
        return was_held

    def _note_caller(self) -> None:
        self._caller = threading.get_ident()


class CommandSpy:
    """Records in ``sent`` the commands that an actuator's driver sends to its hardware, such as a motor's rad/s."""

    def __init__(self, actuator: Actuator[Any]) -> None:
        self.sent: list[Any] = []
        self._apply = actuator._apply  # noqa: SLF001  the hook that every driver implements
        setattr(actuator, "_apply", self._record)  # noqa: B010  on this one actuator, not on its class

    def __repr__(self) -> str:
        return f"CommandSpy(sent={self.sent})"

    @property
    def last(self) -> Any:
        """The last sent command; NaN if there is none."""
        return self.sent[-1] if self.sent else math.nan

    def _record(self, command: Any) -> None:
        self.sent.append(command)
        self._apply(command)


def cut_wire(motor: Motor) -> None:
    """Make every further command to a motor raise DeviceError, as a cut wire does."""

    def fail(_rad_s: float) -> None:
        raise DeviceError(motor.name, "the conformance kit has cut the motor's wire", kind="wire-cut")

    setattr(motor, "_apply", fail)  # noqa: B010  on this one motor, not on its class
