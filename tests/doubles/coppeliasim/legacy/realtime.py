"""Time that passes by itself: a thread that takes a step whenever one is due, while the simulation runs unheld."""

from __future__ import annotations

import threading
import time

from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.doubles.coppeliasim.scene.states import State

STOPPING = {State.ABOUT_TO_STOP, State.LAST_BEFORE_STOP}


class RealTime:
    """Advances a simulator at the pace of the machine's clock, from its making until it is closed.

    Nobody may be stepping: who steps, holds time. The last steps before a stop come at once.
    """

    def __init__(self, simulator: Simulator) -> None:
        self._simulator = simulator
        self._is_over = False
        self._thread = threading.Thread(target=self._run, name="time of a double", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Let time stand still."""
        with self._simulator.lock:
            self._is_over = True
            self._simulator.changed.notify_all()
        self._thread.join()

    def _run(self) -> None:
        changed = self._simulator.changed
        with self._simulator.lock:
            while not self._is_over:
                changed.wait_for(lambda: self._is_over or self._is_free)
                due = time.monotonic() + self._pause
                while self._is_free and not self._is_over and (left := due - time.monotonic()) > 0:
                    changed.wait(left)
                if self._is_free and not self._is_over:
                    self._simulator.advance()

    @property
    def _is_free(self) -> bool:
        return self._simulator.state.is_advancing and not self._simulator.stepping.is_in_use

    @property
    def _pause(self) -> float:
        return 0.0 if self._simulator.state in STOPPING else self._simulator.time_step
