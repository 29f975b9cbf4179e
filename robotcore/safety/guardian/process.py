"""The guardian's process: waits until the app is silent for a lease, then stops its motors."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from queue import SimpleQueue
from socket import socket
from threading import Event
from typing import Literal

from robotcore.errors import ResourceError, RobotcoreError
from robotcore.hal.clock import Clock
from robotcore.hal.cutoff import Cutoff, CutoffSpec, Unconfirmed, shared
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.guardian.protocol import BYE, DRIVING, Assignment, Report, read_line, receive
from robotcore.threads import start_thread

Action = Literal["open", "arm", "rest", "stop", "close"]
"""What a cutoff can be asked for."""

RETRYING_S = 0.5
"""So long a stop that fails is tried again."""

_PAUSE_S = 0.02


class CutoffWorker:
    """Works one cutoff, so that one that fails or hangs holds up no other. Its thread waits ready for a stop.

    If ``in_place`` is set, it has no thread, and `ask` does each deed in the caller's thread. No deed follows a close.
    Raises ResourceError if the system refuses the thread.
    """

    def __init__(self, spec: CutoffSpec, clock: Clock, *, in_place: bool = False) -> None:
        self.device = spec.device
        self._spec, self._clock = spec, clock
        self._cutoff: Cutoff | None = None
        self._is_at_work = True
        self._tasks = SimpleQueue[_Task]()
        self._in_place = in_place
        if not in_place:
            start_thread(self._work, spec.device)

    def ask(self, deed: Action) -> _Task:
        """Have a deed done after those that were asked for before."""
        task = _Task(getattr(self, f"_{deed}"))
        if self._in_place:
            task.do()
        else:
            self._tasks.put(task)
        return task

    def _open(self) -> None:
        self._cutoff = self._spec.make()
        self._cutoff.open()

    def _arm(self) -> None:
        self._opened.arm()

    def _rest(self) -> None:
        self._opened.rest()

    def _stop(self) -> str | None:
        """Stop; again where it fails, for a while."""
        end = self._clock.now() + RETRYING_S
        while True:
            try:
                return self._opened.stop()
            except Exception:
                if self._clock.now() >= end:
                    raise
            self._clock.sleep_until(self._clock.now() + _PAUSE_S)

    def _close(self) -> None:
        self._is_at_work = False
        if self._cutoff:
            self._cutoff.close()

    @property
    def _opened(self) -> Cutoff:
        assert self._cutoff, "open comes first"
        return self._cutoff

    def _work(self) -> None:
        while self._is_at_work:
            self._tasks.get().do()


class _Task:
    """A deed that was asked for, and what became of it."""

    def __init__(self, deed: Callable[[], str | None]) -> None:
        self._deed = deed
        self._is_over = Event()
        self._fault: str | None = None
        self.message: str | None = None

    def do(self) -> None:
        try:
            self.message = self._deed()
        except RobotcoreError as error:
            self._fault = str(error)
        except Exception as error:  # noqa: BLE001  whatever a driver or its vendor's library raises
            self._fault = f"{type(error).__name__}: {error}"
        self._is_over.set()

    def fault_within(self, seconds: float) -> str | None:
        """Return what went wrong, None where nothing did; a deed that is not done in this time hangs."""
        return self._fault if self._is_over.wait(max(0.0, seconds)) else "does not answer"


def run_all(hands: Sequence[CutoffWorker], deed: Action, limit: float, clock: Clock) -> Report:
    """Have all hands do a deed at once, and tell within ``limit`` seconds what became of it."""
    tasks = [hand.ask(deed) for hand in hands]
    end = clock.now() + limit
    faults = [task.fault_within(end - clock.now()) for task in tasks]
    failed = tuple(f"{hand.device}: {fault}" for hand, fault in zip(hands, faults, strict=True) if fault)
    over = [(hand.device, task.message) for hand, task, fault in zip(hands, tasks, faults, strict=True) if not fault]
    done = tuple(device for device, message in over if not isinstance(message, Unconfirmed))
    words = (
        f"{device}: {message}" if isinstance(message, Unconfirmed) else message for device, message in over if message
    )
    return Report(deed, done, failed, tuple(dict.fromkeys(words)))


OPENING_S = 10.0
STOPPING_S = 1.0
"""A cutoff that does not return within this time is reported as hanging."""

ARMING_S = 0.1
"""Shorter: who arms one cutoff does not watch over the others meanwhile. Who is patient with the app is so here too."""


IGNORED_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGABRT)
"""What ends all processes of a terminal or of systemd's unit, SIGABRT where its watchdog does: the app goes first."""


def main() -> None:
    """Guard whatever comes through the socket that the command line names by its number."""
    for number in IGNORED_SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    link = socket(fileno=int(sys.argv[1]))
    link.set_inheritable(False)  # what a vendor's library starts must not hold it open
    with suppress(EOFError):
        assignment = Assignment.from_line(read_line(link))
        try:
            watch = GuardianProcess(link, assignment)
        except ResourceError as error:
            link.sendall(Report("open", (), (str(error),)).to_line())
        else:
            watch.keep()


class GuardianProcess:
    """Guards the motors of one run; ``link`` leads to its process."""

    def __init__(self, link: socket, assignment: Assignment) -> None:
        self._link, self._lease, self._app = link, assignment.lease, assignment.app
        self._clock = MonotonicClock()
        self._hands = [CutoffWorker(spec, self._clock) for spec in assignment.cutoffs]
        self._arming_s = ARMING_S + max(spec.patience_s for spec in assignment.cutoffs)
        self._is_armed = False

    def keep(self) -> None:
        """Open the cutoffs and say so; return when there is nothing left to guard."""
        opened = self._all("open", OPENING_S)
        self._say(opened.to_line())
        if not opened.failed and not self._is_dismissed():
            _log_crash(self._app, self._all("stop", STOPPING_S))
        self._all("close", STOPPING_S)

    def _is_dismissed(self) -> bool:
        """Hear the app until its end, and stop what it leaves turning; return whether it took its leave."""
        while True:
            self._link.settimeout(self._lease if self._is_armed else None)
            try:
                said = receive(self._link)
            except TimeoutError:
                self._is_armed = False
                self._say((stops := self._all("stop", STOPPING_S)).to_line())
                _log(_warnings(stops))  # the app, which fell silent, may never hear of it
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

    def _all(self, deed: Action, limit: float) -> Report:
        return run_all(self._hands, deed, limit, self._clock)

    def _say(self, line: bytes) -> None:
        with suppress(OSError):  # the app is gone: the next read returns its end
            self._link.sendall(line)


def _log_crash(app: int, stops: Report) -> None:
    """Say what nobody else is left to say."""
    stopped = f"the run of process {app} broke off; stopped {', '.join(stops.done) or 'nothing'}"
    _log([*([stopped] if stops.done or stops.failed else []), *stops.messages, *_warnings(stops)])


def _warnings(stops: Report) -> list[str]:
    return [f"CANNOT STOP {fault}. Cut the motors' supply" for fault in stops.failed]


def _log(lines: Iterable[str]) -> None:
    """Say lines on standard error."""
    with suppress(OSError):
        sys.stderr.write("".join(f"guardian: {line}\n" for line in lines))
        sys.stderr.flush()


LIMIT_S = 10.0
"""For each deed of a cutoff, longer than the guardian gives: nobody waits for the next one, and a system that starts or
ends is slow."""


def stop_once(specs: Iterable[CutoffSpec]) -> Report:
    """Open the cutoffs, stop, and close them; return what was stopped, and what could not be, each with its fault.

    One that fails or hangs holds up no other, and nothing is raised. Without threads, which the system may refuse, one
    that hangs holds up those after it.
    """
    clock = MonotonicClock()
    hands = [_make_worker(spec, clock) for spec in shared(specs)]
    opened = run_all(hands, "open", LIMIT_S, clock)
    ready = [hand for hand in hands if hand.device in opened.done]
    stopped = run_all(ready, "stop", LIMIT_S, clock)
    run_all(hands, "close", LIMIT_S, clock)
    return Report("stop", stopped.done, (*opened.failed, *stopped.failed), stopped.messages)


def _make_worker(spec: CutoffSpec, clock: Clock) -> CutoffWorker:
    """Return a hand with a thread of its own, or without one if the system refuses it: a stop needs none."""
    try:
        return CutoffWorker(spec, clock)
    except ResourceError:
        return CutoffWorker(spec, clock, in_place=True)
