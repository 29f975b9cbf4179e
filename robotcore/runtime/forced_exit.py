"""End the process if a run cannot end by itself: an app or a driver hangs, or a third signal arrives."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial

from robotcore.errors import DeviceClosedError, Interrupted, RobotcoreError
from robotcore.runtime.layers import Assembled
from robotcore.runtime.result import RunResult
from robotcore.runtime.signals import SignalGuard
from robotcore.safety.thread_reserve import Reserve

SHUTDOWN_GRACE_S = 0.2
"""On a forced exit, closing the robot and each receiver of the result get this time, in seconds."""

SHUTDOWN_THREADS = 4
"""The calls that may hang on a forced exit, each in its own thread: latch, closing, observers, ``on_forced_exit``."""


def print_reason(result: RunResult) -> None:
    """Print the reason on standard error, past Python's stream: the hanging thread may hold its lock."""
    os.write(2, f"error: {result.reason}\n".encode())


class ForcedExit:
    """Ends the process of a run, after the result went to its receivers.

    signals: the guard of the run. A run outside the main thread does not end its process.
    reserve: its threads call the receivers, because a receiver may hang too.
    receivers: called one after the other with the result.
    """

    def __init__(
        self, signals: SignalGuard, reserve: Reserve, receivers: Sequence[Callable[[RunResult], object]]
    ) -> None:
        self._signals, self._reserve, self._receivers = signals, reserve, receivers

    def end_after_hang(self, error: RobotcoreError, build_result: Callable[[RobotcoreError], RunResult]) -> None:
        """End the process after the watchdog's error. The motors are stopped already."""
        if self._signals.is_in_main_thread:
            try:
                self._reserve.release_memory()
                self._report(build_result(error))
            finally:
                os._exit(error.exit_status)

    def stop_after_signals(self, assembled: Assembled, build_result: Callable[[Interrupted], RunResult]) -> None:
        """Stop every motor and report the result. `SignalGuard` then ends the process.

        The latch trips in another thread, because this thread may be in a call that hangs.
        """
        self._reserve.release_memory()
        try:
            trip = partial(assembled.latch.set, DeviceClosedError(assembled.robot.name))
            self._reserve.call(trip).is_done_within(SHUTDOWN_GRACE_S)
        finally:
            try:
                assembled.brakes.apply_apart()
            finally:
                if self._signals.raised:
                    self._report(build_result(self._signals.raised))

    def _report(self, result: RunResult) -> None:
        for receive in self._receivers:
            self._reserve.call(partial(receive, result)).is_done_within(SHUTDOWN_GRACE_S)
