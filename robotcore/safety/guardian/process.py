"""The guardian process: stops the motors if the app's process dies or does not renew the lease in time."""

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
from robotcore.hal.cutoff import Cutoff, CutoffSpec, Unconfirmed, merge_cutoffs
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.guardian.protocol import BYE, DRIVING, Assignment, Report, read_line, receive
from robotcore.threads import start_thread

Action = Literal["open", "arm", "rest", "stop", "close"]
"""A method of `Cutoff`."""

RETRYING_S = 0.5
"""The time for which a stop that fails is repeated, in seconds."""

_PAUSE_S = 0.02


class CutoffWorker:
    """Runs one cutoff in a thread of its own, so that a cutoff that fails or hangs does not delay the others.

    If ``in_place`` is set, there is no thread, and `submit` runs each action in the caller's thread. The thread ends
    after the action `close`. Raises ResourceError if the system refuses the thread.
    """

    def __init__(self, spec: CutoffSpec, clock: Clock, *, in_place: bool = False) -> None:
        self.device = spec.device
        self._spec, self._clock = spec, clock
        self._cutoff: Cutoff | None = None
        self._is_running = True
        self._tasks = SimpleQueue[_Task]()
        self._in_place = in_place
        if not in_place:
            start_thread(self._work, spec.device)

    def submit(self, action: Action) -> _Task:
        """Queue an action, and return its task."""
        task = _Task(getattr(self, f"_{action}"))
        if self._in_place:
            task.run()
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
        """Stop the motors. Repeat a stop that fails until `RETRYING_S` has passed."""
        end = self._clock.now() + RETRYING_S
        while True:
            try:
                return self._opened.stop()
            except Exception:
                if self._clock.now() >= end:
                    raise
            self._clock.sleep_until(self._clock.now() + _PAUSE_S)

    def _close(self) -> None:
        self._is_running = False
        if self._cutoff:
            self._cutoff.close()

    @property
    def _opened(self) -> Cutoff:
        assert self._cutoff, "the cutoff is not open"
        return self._cutoff

    def _work(self) -> None:
        while self._is_running:
            self._tasks.get().run()


class _Task:
    """A queued action and its result."""

    def __init__(self, action: Callable[[], str | None]) -> None:
        self._action = action
        self._is_over = Event()
        self._fault: str | None = None
        self.message: str | None = None

    def run(self) -> None:
        try:
            self.message = self._action()
        except RobotcoreError as error:
            self._fault = str(error)
        except Exception as error:  # noqa: BLE001  a driver or a vendor's library may raise any exception
            self._fault = f"{type(error).__name__}: {error}"
        self._is_over.set()

    def wait(self, seconds: float) -> str | None:
        """Wait at most ``seconds`` for the action. Return its fault as a text, or None if it succeeded."""
        return self._fault if self._is_over.wait(max(0.0, seconds)) else "does not answer"


def run_all(workers: Sequence[CutoffWorker], action: Action, limit: float, clock: Clock) -> Report:
    """Run an action on all cutoffs in parallel. Return the report after at most ``limit`` seconds."""
    tasks = [(worker.device, worker.submit(action)) for worker in workers]
    end = clock.now() + limit
    results = [(device, task.wait(end - clock.now()), task.message) for device, task in tasks]
    failed = tuple(f"{device}: {fault}" for device, fault, _ in results if fault)
    succeeded = [(device, message) for device, fault, message in results if not fault]
    done = tuple(device for device, message in succeeded if not isinstance(message, Unconfirmed))
    messages = (
        f"{device}: {message}" if isinstance(message, Unconfirmed) else message
        for device, message in succeeded
        if message
    )
    return Report(action, done, failed, tuple(dict.fromkeys(messages)))


OPENING_S = 10.0
STOPPING_S = 1.0
"""The time limits for opening a cutoff and for stopping the motors, in seconds.

A cutoff that exceeds a limit is reported as ``does not answer``.
"""

ARMING_S = 0.1
"""The time limit for arming the cutoffs, in seconds. The longest ``patience_s`` of the cutoffs is added.

It is short, because the guardian does not check the app's lease while it arms.
"""


IGNORED_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGABRT)
"""The signals that the guardian ignores, because the app must end first.

They are sent to all processes of a terminal or of a systemd unit. The watchdog of systemd sends SIGABRT.
"""


def main() -> None:
    """Read the assignment from a socket, and guard the motors. The command line contains the socket's number."""
    for number in IGNORED_SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    link = socket(fileno=int(sys.argv[1]))
    link.set_inheritable(False)  # a child process must not keep it open
    with suppress(EOFError):
        assignment = Assignment.from_line(read_line(link))
        try:
            guardian = GuardianProcess(link, assignment)
        except ResourceError as error:
            link.sendall(Report("open", (), (f"the cutoffs: {error}",)).to_line())
        else:
            guardian.run()


class GuardianProcess:
    """Guards the motors of one run. ``link`` is the socket to the app's process."""

    def __init__(self, link: socket, assignment: Assignment) -> None:
        self._link, self._lease, self._app = link, assignment.lease, assignment.app
        self._clock = MonotonicClock()
        self._workers = [CutoffWorker(spec, self._clock) for spec in assignment.cutoffs]
        self._arming_s = ARMING_S + max(spec.patience_s for spec in assignment.cutoffs)
        self._is_armed = False

    def run(self) -> None:
        """Open the cutoffs, send a report about it, and guard the motors until the app ends."""
        opened = self._run_all("open", OPENING_S)
        self._send(opened.to_line())
        if not opened.failed and not self._serve():
            _log_crash(self._app, self._run_all("stop", STOPPING_S))
        self._run_all("close", STOPPING_S)

    def _serve(self) -> bool:
        """Answer the app until it ends, and stop the motors whenever a lease expires.

        Return whether the app sent `BYE`, and so has not died.
        """
        while True:
            self._link.settimeout(self._lease if self._is_armed else None)
            try:
                received = receive(self._link)
            except TimeoutError:
                self._is_armed = False
                self._send((stops := self._run_all("stop", STOPPING_S)).to_line())
                _log(_warnings(stops))  # a suspended app may never read the report, so print it
                continue
            if not received or received.endswith(BYE):
                return bool(received)
            self._send(b"\n")
            self._update_lease(is_driving=received.endswith(DRIVING))

    def _update_lease(self, *, is_driving: bool) -> None:
        """Arm the cutoffs if a lease has begun, or rest them if it has ended."""
        if is_driving != self._is_armed:
            changed = self._run_all("arm" if is_driving else "rest", self._arming_s)
            if changed.failed:
                self._send(changed.to_line())
        self._is_armed = is_driving

    def _run_all(self, action: Action, limit: float) -> Report:
        return run_all(self._workers, action, limit, self._clock)

    def _send(self, line: bytes) -> None:
        with suppress(OSError):  # the app is gone: the next read ends the run
            self._link.sendall(line)


def _log_crash(app: int, stops: Report) -> None:
    """Write to stderr which motors were stopped after the app's process had died."""
    stopped = f"the run of process {app} broke off; stopped {', '.join(stops.done) or 'nothing'}"
    _log([*([stopped] if stops.done or stops.failed else []), *stops.messages, *_warnings(stops)])


def _warnings(stops: Report) -> list[str]:
    return [f"CANNOT STOP {fault}. Cut the motors' supply" for fault in stops.failed]


def _log(lines: Iterable[str]) -> None:
    """Write lines to stderr."""
    with suppress(OSError):
        sys.stderr.write("".join(f"guardian: {line}\n" for line in lines))
        sys.stderr.flush()


LIMIT_S = 10.0
"""The time limit for each action of `stop_once`, in seconds.

It is longer than the guardian's limits, because a system that starts or shuts down is slow.
"""


def stop_once(specs: Iterable[CutoffSpec]) -> Report:
    """Open the cutoffs, stop the motors, and close the cutoffs. Return a report of the stopped devices and the faults.

    A cutoff that fails or hangs does not delay the others. Faults are reported and not raised. If the system refuses
    threads, the cutoffs run one after the other, and one that hangs delays the next.
    """
    clock = MonotonicClock()
    workers = [_make_worker(spec, clock) for spec in merge_cutoffs(specs)]
    opened = run_all(workers, "open", LIMIT_S, clock)
    ready = [worker for worker in workers if worker.device in opened.done]
    stopped = run_all(ready, "stop", LIMIT_S, clock)
    run_all(workers, "close", LIMIT_S, clock)
    return Report("stop", stopped.done, (*opened.failed, *stopped.failed), stopped.messages)


def _make_worker(spec: CutoffSpec, clock: Clock) -> CutoffWorker:
    """Return a worker for a cutoff. If the system refuses a thread, the worker runs in the caller's thread."""
    try:
        return CutoffWorker(spec, clock)
    except ResourceError:
        return CutoffWorker(spec, clock, in_place=True)
