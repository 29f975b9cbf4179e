"""An observer that reports a run's state to systemd (``Type=notify``).

Source: sd_notify(3), sd_watchdog_enabled(3). Libraries for it (sdnotify, systemd-watchdog, python-systemd) block while
systemd does not read its socket, which a control loop must not do.
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
"""What systemd puts into the environment of a service's process."""

READY, ALIVE = "READY=1", "WATCHDOG=1"

STOPPING = "STOPPING=1\nEXTEND_TIMEOUT_USEC=60000000"
"""With it systemd's time to stop begins, after which it kills, and takes a run that ended well for a failure; a
recording may need more on a slow disk, and has its own end after a minute."""

FAILED = 6
"""The exit status of a service that ended by itself, and not well. Python has 1 for whatever it cannot go on from."""

FEED_S = 0.5
"""A watchdog is fed as often, or more often: whoever looks when it last was knows soon whether the loop lives."""

STATUS_S = 1.0
"""A status is told no more often."""

LONGEST = 200
"""A status is one short line, in characters."""


class Notifier:
    """An observer that tells systemd: ready with the first tick that went well, alive from then on, at last the end.

    Whatever becomes of the socket, nothing is raised, and nobody is waited for: what systemd does not take at once is
    lost, but for what the next tick says again. Who is alive is the loop's own thread, for it says so itself, four
    times in ``watchdog_s`` at least, and twice a second, where ticks come as often.
    """

    def __init__(self, address: str, watchdog_s: float | None = None, clock: Clock | None = None) -> None:
        """``address`` is a path, or the name of an abstract socket after ``@``; no watchdog is fed without its time."""
        self._address = f"\0{address[1:]}" if address.startswith("@") else address
        self._clock = clock or MonotonicClock()
        self._feed_s = min(watchdog_s / 4, FEED_S) if watchdog_s else None
        self._fed = self._status_sent = -inf
        self._outer: BaseException | None = None
        self._is_ready = False

    @classmethod
    def of(cls, environment: MutableMapping[str, str]) -> Notifier | None:
        """Return what tells systemd, where this process is the one to do so, and take that out of the environment.

        So no process that is started from here on takes it for its own.
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
            self._is_ready = self._goes_well and self._say(READY)
        if self._feed_s is not None and now - self._fed >= self._feed_s and self._say(ALIVE):
            self._fed = now
        if now - self._status_sent >= STATUS_S and self._say(_status(_under_way(record))):
            self._status_sent = now

    def end(self, result: RunResult) -> None:
        self._say(STOPPING, _status(": ".join(filter(None, (result.outcome.value, result.reason)))))

    @staticmethod
    def completed(result: RunResult) -> RunResult:
        """Return a result with a service's exit status, by which systemd tells what is to be started again.

        One that hung has that of an app that raised: a program at fault, and nothing that the safety stage found, which
        somebody has to look at before anything turns again. One that came to its end, and not well, has `FAILED`.
        """
        if isinstance(result.error, WatchdogError):
            return replace(result, exit_status=BehaviourError.exit_status)
        return replace(result, exit_status=FAILED) if result.exit_status and not result.error else result

    @property
    def _goes_well(self) -> bool:
        """Whether nothing is ending the run in this tick: the loop notes a tick while that passes by."""
        return sys.exc_info()[1] is self._outer

    def _say(self, *lines: str) -> bool:
        """Send lines; return whether systemd has them."""
        with suppress(OSError), socket(AF_UNIX, SOCK_DGRAM) as link:
            link.sendto("\n".join(lines).encode(errors="replace"), MSG_DONTWAIT, self._address)
            return True
        return False


def _under_way(record: TickRecord) -> str:
    return ", ".join(filter(None, (record.doing, f"{record.time:.0f} s", format_voltages(record.voltages))))


def _status(words: str) -> str:
    return f"STATUS={' '.join(words.split())[:LONGEST]}"
