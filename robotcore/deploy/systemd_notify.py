"""An observer that reports the state of a run to systemd, for a service with ``Type=notify``.

Source: sd_notify(3), sd_watchdog_enabled(3). The libraries sdnotify, systemd-watchdog and python-systemd block while
systemd does not read its socket, but a control loop must not block.
"""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import MutableMapping
from contextlib import suppress
from dataclasses import replace
from math import inf

from robotcore.errors import BehaviourError, WatchdogError
from robotcore.hal.clock import Clock
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.observer import RunContext
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord, format_monitored

SOCKET, WATCHDOG_US, WATCHDOG_PID = "NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"
"""The environment variables that systemd sets for the process of a service."""

READY, ALIVE = "READY=1", "WATCHDOG=1"

STOPPING = "STOPPING=1\nEXTEND_TIMEOUT_USEC=60000000"
"""The message at the end of a run. systemd then waits 60 s, because the recorder may need them on a slow disk."""

FAILED = 6
"""The exit status of a service that ended by itself without success. An uncaught exception has the status 1."""

FEED_S = 0.5
"""The greatest time between two resets of the watchdog, in s. A health check needs a recent reset."""

STATUS_S = 1.0
"""The least time between two status texts, in s."""

MAX_STATUS_LENGTH = 200
"""The greatest length of a status text, in characters."""


class Notifier:
    """An observer of a run that reports to systemd that the app is ready, that it is alive, and that it ends.

    The app is ready after the first tick without an error. The control loop's thread resets systemd's watchdog, so the
    watchdog detects a loop that hangs.

    The notifier never raises and never blocks. If systemd does not accept a message at once, the next tick repeats it.

    address: the path of systemd's socket, or ``@`` and the name of an abstract socket.
    watchdog_s: the time limit of systemd's watchdog, in s; None without a watchdog. The notifier resets it every
        quarter of this time, and at least every `FEED_S`, if the ticks are frequent enough.
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
    def from_environment(cls, environment: MutableMapping[str, str]) -> Notifier | None:
        """Return a notifier if systemd expects messages of this process, else None.

        environment: the environment variables of this process. The method deletes systemd's variables from it, so that
            child processes send no messages.
        """
        address, period_us, pid = (environment.pop(name, "") for name in (SOCKET, WATCHDOG_US, WATCHDOG_PID))
        if not address.startswith(("/", "@")) or (pid and pid != str(os.getpid())):
            return None
        return cls(address, int(period_us) / 1e6 if period_us.isdecimal() else None)

    def begin(self, run: RunContext) -> None:
        self._outer = sys.exc_info()[1]

    def tick(self, record: TickRecord) -> None:
        now = self._clock.now()
        if not self._is_ready:
            self._is_ready = self._has_no_error and self._send(READY)
        if self._feed_s is not None and now - self._fed >= self._feed_s and self._send(ALIVE):
            self._fed = now
        if now - self._status_sent >= STATUS_S and self._send(_format_status(_format_progress(record))):
            self._status_sent = now

    def end(self, result: RunResult) -> None:
        self._send(STOPPING, _format_status(": ".join(filter(None, (result.outcome.value, result.reason)))))

    @staticmethod
    def choose_exit_status(result: RunResult) -> RunResult:
        """Return the result with the exit status that decides whether systemd restarts the app.

        A run that hung gets the exit status of an app that raised, so systemd restarts it. A run that ended by itself
        without success gets `FAILED`, so systemd does not restart it.
        """
        if isinstance(result.error, WatchdogError):
            return replace(result, exit_status=BehaviourError.exit_status)
        return replace(result, exit_status=FAILED) if result.exit_status and not result.error else result

    @property
    def _has_no_error(self) -> bool:
        """Whether no exception ends the run in this tick. The control loop also reports the tick of an exception."""
        return sys.exc_info()[1] is self._outer

    def _send(self, *lines: str) -> bool:
        with suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as link:
            link.sendto("\n".join(lines).encode(errors="replace"), socket.MSG_DONTWAIT, self._address)
            return True
        return False


def _format_progress(record: TickRecord) -> str:
    return ", ".join(filter(None, (record.status_text, f"{record.time:.0f} s", format_monitored(record.monitored))))


def _format_status(text: str) -> str:
    return f"STATUS={' '.join(text.split())[:MAX_STATUS_LENGTH]}"
