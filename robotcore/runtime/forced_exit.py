"""Ends the process if an app or a driver hangs at the end of a run, or if the user sends a third signal (Ctrl-C)."""

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
"""The time limit on a forced exit for closing the robot, and for each function that gets the result, in seconds."""

SHUTDOWN_THREADS = 4
"""The number of reserved threads for the calls that may hang on a forced exit.

The calls are the latch, the closing of the robot, the observers and ``on_forced_exit``.
"""


def print_reason(result: RunResult) -> None:
    """Print the reason of a forced exit on standard error.

    The text does not pass through ``sys.stderr``, because a thread that hangs may hold its lock.
    """
    os.write(2, f"error: {result.reason}\n".encode())


class ForcedExit:
    """Reports the result of a run, then ends the process.

    signals: the signal guard of the run. The process is ended only if the run is in the main thread.
    reserve: the threads that call ``receivers``, because such a call may hang too.
    receivers: the functions that get the result. They are called one after the other.
    """

    def __init__(
        self, signals: SignalGuard, reserve: Reserve, receivers: Sequence[Callable[[RunResult], object]]
    ) -> None:
        self._signals, self._reserve, self._receivers = signals, reserve, receivers

    def end_after_hang(self, error: RobotcoreError, build_result: Callable[[RobotcoreError], RunResult]) -> None:
        """End the process after the watchdog has reported a hang and stopped the motors.

        error: the error of the watchdog.
        build_result: a function that returns the result of the run for this error.
        """
        if self._signals.is_in_main_thread:
            try:
                self._reserve.release_memory()
                self._report(build_result(error))
            finally:
                os._exit(error.exit_status)

    def stop_after_signals(self, assembled: Assembled, build_result: Callable[[Interrupted], RunResult]) -> None:
        """Stop every motor and report the result. `SignalGuard` then ends the process.

        Another thread trips the latch, because the last signal may have interrupted this thread in a call that hangs.
        """
        self._reserve.release_memory()
        try:
            trip = partial(assembled.latch.set, DeviceClosedError(assembled.robot.name))
            self._reserve.call(trip).is_done_within(SHUTDOWN_GRACE_S)
        finally:
            try:
                assembled.motor_stops.apply_apart()
            finally:
                if self._signals.raised:
                    self._report(build_result(self._signals.raised))

    def _report(self, result: RunResult) -> None:
        for receive in self._receivers:
            self._reserve.call(partial(receive, result)).is_done_within(SHUTDOWN_GRACE_S)
