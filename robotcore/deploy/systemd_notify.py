"""An observer that reports a run's state to systemd (``Type=notify``).

Source: sd_notify(3), sd_watchdog_enabled(3). The libraries sdnotify, systemd-watchdog and python-systemd block while
systemd does not read its socket. A control loop must not block.
"""

from __future__ import annotations

import os
import sys
from collections.abc import MutableMapping
from contextlib import suppress
from dataclasses import replace
from math import inf
from socket import AF_UNIX, MSG_DONTWAIT, SOCK_DGRAM, socket

from robotcore.errors import BehaviourError, WatchdogError
from robotcore.hal.clock import Clock
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.observer import Run
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord, format_voltages

SOCKET, WATCHDOG_US, WATCHDOG_PID = "NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"
"""The variables that systemd sets for a service's process."""

READY, ALIVE = "READY=1", "WATCHDOG=1"

STOPPING = "STOPPING=1\nEXTEND_TIMEOUT_USEC=60000000"
"""The message at the end of a run. It makes systemd wait a minute (stated in µs) before it kills the process.

The recorder may need that minute to finish a recording on a slow disk.
"""

FAILED = 6
"""The exit status of a service that ended by itself without success. Python itself uses 1 for an uncaught exception."""

FEED_S = 0.5
"""The longest time between two resets of the watchdog, in s. A health check requires a recent reset."""

STATUS_S = 1.0
"""The shortest time between two status texts, in s."""

LONGEST = 200
"""The longest status text, in characters."""


class Notifier:
    """An observer of a run that reports to systemd: first that the app is ready, then that it is alive, then its end.

    The app is ready after the first tick without an error.

    It never raises and never blocks. A message that systemd does not accept at once is lost; the next tick repeats it.
    The thread of the control loop resets the watchdog. So the watchdog detects a loop that hangs.

    address: the path of systemd's socket, or ``@`` and the name of an abstract socket.
    watchdog_s: the time limit of systemd's watchdog, in s; None if there is no watchdog. It is reset at least four
        times within this limit, and at least every `FEED_S`, if the ticks are frequent enough.
    clock: the clock that times the resets; by default the machine's monotonic clock.
    """

    def __init__(self, address: str, watchdog_s: float | None = None, clock: Clock | None = None) -> None:
        self._address = f"\0{address[1:]}" if address.startswith("@") else address
        self._clock = clock or MonotonicClock()
        self._feed_s = min(watchdog_s / 4, FEED_S) if watchdog_s else None
        self._fed = self._status_sent = -inf
        self._outer: BaseException | None = None
        self._is_ready = False

    @classmethod
    def of(cls, environment: MutableMapping[str, str]) -> Notifier | None:
        """Return a notifier if systemd expects messages of this process, else None.

        The function deletes systemd's variables from the environment, so that child processes do not send messages.

        environment: the variables of this process.
        """
        address, period_us, pid = (environment.pop(name, "") for name in (SOCKET, WATCHDOG_US, WATCHDOG_PID))
        if not address.startswith(("/", "@")) or (pid and pid != str(os.getpid())):
            return None
        return cls(address, int(period_us) / 1e6 if period_us.isdecimal() else None)

    def begin(self, run: Run) -> None:
        self._outer = sys.exc_info()[1]

    def tick(self, record: TickRecord) -> None:
        now = self._clock.now()
        if not self._is_ready:
            self._is_ready = self._is_well and self._send(READY)
        if self._feed_s is not None and now - self._fed >= self._feed_s and self._send(ALIVE):
            self._fed = now
        if now - self._status_sent >= STATUS_S and self._send(_format_status(_format_progress(record))):
            self._status_sent = now

    def end(self, result: RunResult) -> None:
        self._send(STOPPING, _format_status(": ".join(filter(None, (result.outcome.value, result.reason)))))

    @staticmethod
    def choose_exit_status(result: RunResult) -> RunResult:
        """Return the result with the exit status of a service, which decides whether systemd restarts the app.

        A run that hung has the status of an app that raised, so that it is restarted. Without this, it would have the
        status of a safety stop, after which a user must look first. A run that ended without success has `FAILED`.
        """
        if isinstance(result.error, WatchdogError):
            return replace(result, exit_status=BehaviourError.exit_status)
        return replace(result, exit_status=FAILED) if result.exit_status and not result.error else result

    @property
    def _is_well(self) -> bool:
        """Whether no exception ends the run in this tick. The loop also reports the tick of an exception."""
        return sys.exc_info()[1] is self._outer

    def _send(self, *lines: str) -> bool:
        """Send lines to systemd; return whether systemd accepted them."""
        with suppress(OSError), socket(AF_UNIX, SOCK_DGRAM) as link:
            link.sendto("\n".join(lines).encode(errors="replace"), MSG_DONTWAIT, self._address)
            return True
        return False


def _format_progress(record: TickRecord) -> str:
    return ", ".join(filter(None, (record.doing, f"{record.time:.0f} s", format_voltages(record.voltages))))


def _format_status(text: str) -> str:
    return f"STATUS={' '.join(text.split())[:LONGEST]}"
