"""What the guardian's process does with its life: waits for the app to fall silent, and then stops its motors."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterable
from contextlib import suppress
from socket import socket

from robotcore.errors import ResourceError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.guardian.hand import Deed, Hand, together
from robotcore.safety.guardian.link import BYE, DRIVING, Assignment, Report, first_line, heard

OPENING_S = 10.0
STOPPING_S = 1.0
"""A cutoff that has not come back by then hangs, and is told."""

ARMING_S = 0.1
"""Shorter: who arms one cutoff does not watch over the others meanwhile. Who is patient with the app is so here too."""


DEAF_TO = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGABRT)
"""What ends all processes of a terminal or of systemd's unit, SIGABRT where its watchdog does: the app goes first."""


def main() -> None:
    """Guard whatever comes through the socket that the command line names by its number."""
    for number in DEAF_TO:
        signal.signal(number, signal.SIG_IGN)
    link = socket(fileno=int(sys.argv[1]))
    link.set_inheritable(False)  # what a vendor's library starts must not hold it open
    with suppress(EOFError):
        assignment = Assignment.from_line(first_line(link))
        try:
            watch = Watch(link, assignment)
        except ResourceError as error:
            link.sendall(Report("open", (), (str(error),)).to_line())
        else:
            watch.keep()


class Watch:
    """Guards the motors of one run; ``link`` leads to its process."""

    def __init__(self, link: socket, assignment: Assignment) -> None:
        self._link, self._lease, self._app = link, assignment.lease, assignment.app
        self._clock = MonotonicClock()
        self._hands = [Hand(spec, self._clock) for spec in assignment.cutoffs]
        self._arming_s = ARMING_S + max(spec.patience_s for spec in assignment.cutoffs)
        self._is_armed = False

    def keep(self) -> None:
        """Open the cutoffs and say so; return when there is nothing left to guard."""
        opened = self._all("open", OPENING_S)
        self._say(opened.to_line())
        if not opened.failed and not self._is_dismissed():
            _cry(self._app, self._all("stop", STOPPING_S))
        self._all("close", STOPPING_S)

    def _is_dismissed(self) -> bool:
        """Hear the app until its end, and stop what it leaves turning; return whether it took its leave."""
        while True:
            self._link.settimeout(self._lease if self._is_armed else None)
            try:
                said = heard(self._link)
            except TimeoutError:
                self._is_armed = False
                self._say((stops := self._all("stop", STOPPING_S)).to_line())
                _tell(_warnings(stops))  # the app, which fell silent, may never hear of it
                continue
            if not said or said.endswith(BYE):
                return bool(said)
            self._say(b"\n")
            self._attend(is_driving=said.endswith(DRIVING))

    def _attend(self, *, is_driving: bool) -> None:
        """Begin a lease, or end it."""
        if is_driving != self._is_armed:
            turned = self._all("arm" if is_driving else "rest", self._arming_s)
            if turned.failed:
                self._say(turned.to_line())
        self._is_armed = is_driving

    def _all(self, deed: Deed, limit: float) -> Report:
        return together(self._hands, deed, limit, self._clock)

    def _say(self, line: bytes) -> None:
        with suppress(OSError):  # the app is gone: the next thing heard is its end
            self._link.sendall(line)


def _cry(app: int, stops: Report) -> None:
    """Say what nobody else is left to say."""
    stopped = f"the run of process {app} broke off; stopped {', '.join(stops.done) or 'nothing'}"
    _tell([*([stopped] if stops.done or stops.failed else []), *stops.told, *_warnings(stops)])


def _warnings(stops: Report) -> list[str]:
    return [f"CANNOT STOP {fault}. Cut the motors' supply" for fault in stops.failed]


def _tell(lines: Iterable[str]) -> None:
    """Say lines on standard error."""
    with suppress(OSError):
        sys.stderr.write("".join(f"guardian: {line}\n" for line in lines))
        sys.stderr.flush()
