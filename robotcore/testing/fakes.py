"""Test doubles for drivers: a gate that holds up hardware calls, and a spy on a motor's commands."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from robotcore.errors import DeviceError
from robotcore.hal.devices import Motor

PATIENCE_S = 5.0
"""How long a read may take that neither returns nor comes to the gate: one that waits for a lock."""


class Gate:
    """Holds a fake transport's answers back while it is shut.

    Let the fake call `pass_through` wherever the real hardware would take its time.

    >>> gate = Gate()
    >>> gate.holds_up(gate.pass_through)
    True
    >>> gate.holds_up(lambda: None)
    False
    """

    def __init__(self) -> None:
        self._is_open = threading.Event()
        self._is_open.set()
        self._settled = threading.Event()
        self._caller: int | None = None

    def pass_through(self) -> None:
        """Return when the gate is open."""
        if threading.get_ident() == self._caller and not self._is_open.is_set():
            self._settled.set()
        self._is_open.wait()

    def holds_up(self, call: Callable[[], object]) -> bool:
        """Shut the gate, call, open the gate; return whether the call could not return before.

        Raises what the call raised.
        """
        self._settled.clear()
        self._is_open.clear()
        with ThreadPoolExecutor(1, initializer=self._note_caller) as caller:
            result = caller.submit(call)
            result.add_done_callback(lambda _: self._settled.set())
            self._settled.wait(PATIENCE_S)
            was_held = not result.done()
            self._is_open.set()
        result.result()
        return was_held

    def _note_caller(self) -> None:
        self._caller = threading.get_ident()


class MotorSpy:
    """Keeps what reaches a motor's hardware, in rad/s, and lets it through."""

    def __init__(self, motor: Motor) -> None:
        self.sent: list[float] = []
        self._apply = motor._apply  # noqa: SLF001  the hook that every driver fills in
        setattr(motor, "_apply", self._note)  # noqa: B010  on this one motor, not on its class

    @property
    def last(self) -> float:
        """What was sent last; NaN where nothing was."""
        return self.sent[-1] if self.sent else math.nan

    def _note(self, rad_s: float) -> None:
        self.sent.append(rad_s)
        self._apply(rad_s)


def cut_wire(motor: Motor) -> None:
    """From now on, let every command to this motor fail."""

    def fail(_rad_s: float) -> None:
        raise DeviceError(motor.name, "the kit has cut its wire")

    setattr(motor, "_apply", fail)  # noqa: B010  on this one motor, not on its class
