"""The guardian process: stops the motors if the app's process dies or does not renew the lease in time."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import Future, wait
from contextlib import suppress
from functools import partial
from queue import SimpleQueue
from socket import socket
from typing import Literal

from robotcore.child_process import receive_link
from robotcore.errors import ResourceError, RobotcoreError
from robotcore.hal.clock import Clock
from robotcore.hal.cutoff import Cutoff, CutoffSpec, UnconfirmedStop, merge_cutoffs
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.guardian.protocol import BEGIN_LEASE, END, Assignment, GuardianReply, read_line, receive
from robotcore.safety.real_time import lock_memory, read_priority_and_locked_memory
from robotcore.threads import start_thread

Action = Literal["open", "arm", "disarm", "stop", "close"]
"""The name of an action, which is a method of `Cutoff`."""

RETRYING_S = 0.5
"""The time during which a stop that fails is repeated, in seconds."""

_PAUSE_S = 0.02


class CutoffWorker:
    """Runs the actions of one cutoff in a thread of its own, so that a cutoff that hangs does not delay the others.

    runs_in_caller_thread: whether `submit` runs each action in the caller's thread, and there is no other thread.

    The thread ends after the action ``close``. Raises ResourceError if the system refuses the thread.
    """

    def __init__(self, spec: CutoffSpec, clock: Clock, *, runs_in_caller_thread: bool = False) -> None:
        self.device = spec.device
        self._spec, self._clock = spec, clock
        self._cutoff: Cutoff | None = None
        self._is_running = True
        self._tasks = SimpleQueue[tuple[Action, Future[str | None]]]()
        self._in_place = runs_in_caller_thread
        if not runs_in_caller_thread:
            start_thread(self._work, spec.device)

    def submit(self, action: Action) -> Future[str | None]:
        """Queue an action, and return the future of its message."""
        future = Future[str | None]()
        if self._in_place:
            self._run(action, future)
        else:
            self._tasks.put((action, future))
        return future

    def _work(self) -> None:
        while self._is_running:
            self._run(*self._tasks.get())

    def _run(self, action: Action, future: Future[str | None]) -> None:
        try:
            future.set_result(self._do(action))
        except Exception as error:  # noqa: BLE001  a driver or a vendor's library may raise any exception
            future.set_exception(error)

    def _do(self, action: Action) -> str | None:
        if action == "close":
            self._is_running = False
            if self._cutoff is None:
                return None
        cutoff = self._cutoff = self._cutoff or self._spec.make()
        if action == "stop":
            return self._stop(cutoff)
        getattr(cutoff, action)()  # only a stop returns a message
        return None

    def _stop(self, cutoff: Cutoff) -> str | None:
        # A stop that fails is repeated for `RETRYING_S`.
        end = self._clock.now() + RETRYING_S
        while True:
            try:
                return cutoff.stop()
            except Exception:
                if self._clock.now() >= end:
                    raise
            self._clock.sleep_until(self._clock.now() + _PAUSE_S)


def run_all(workers: Sequence[CutoffWorker], action: Action, limit: float) -> GuardianReply:
    """Run one action on each cutoff in parallel, and wait at most ``limit`` seconds. Return which cutoffs finished."""
    tasks = [(worker.device, worker.submit(action)) for worker in workers]
    finished, _ = wait([future for _, future in tasks], limit)
    done, failed, messages = [], [], []
    for device, future in tasks:
        if future not in finished:
            failed.append(f"{device}: does not answer")
        elif error := future.exception():
            problem = str(error) if isinstance(error, RobotcoreError) else f"{type(error).__name__}: {error}"
            failed.append(f"{device}: {problem}")
        elif isinstance(message := future.result(), UnconfirmedStop):
            messages.append(f"{device}: {message}")
        else:
            done.append(device)
            messages += [message] if message else []
    return GuardianReply(action, tuple(done), tuple(failed), tuple(dict.fromkeys(messages)))


OPENING_S = 10.0
"""The time limit for opening the cutoffs, in seconds. A slower cutoff is reported as ``does not answer``."""

STOPPING_S = 1.0
"""The time limit for stopping the motors, in seconds."""

ARMING_S = 0.1
"""The time limit for arming the cutoffs, in seconds, to which their longest ``extra_lease_s`` is added.

It is short, because the guardian does not check the lease while it arms.
"""


_IGNORED = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK", "SIGABRT")

IGNORED_SIGNALS = [getattr(signal, name) for name in _IGNORED if hasattr(signal, name)]
"""The signals that the guardian ignores, because the app must end first.

A terminal or systemd sends them to the app and to the guardian. The watchdog of systemd sends SIGABRT.
"""


def main() -> None:
    """Read the assignment from the link, and guard the motors. The first argument is the address of the link."""
    for number in IGNORED_SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    link = receive_link(sys.argv[1])
    with suppress(EOFError):
        assignment = Assignment.from_line(read_line(link))
        if read_priority_and_locked_memory()["priority"]:  # the app runs with --rt, and reports if this is refused
            lock_memory()
        try:
            guardian = GuardianProcess(link, assignment)
        except ResourceError as error:
            link.sendall(GuardianReply("open", (), (f"the cutoffs: {error}",)).to_line())
        else:
            guardian.run()


class GuardianProcess:
    """Guards the motors of one run. ``link`` is the socket to the app's process."""

    def __init__(self, link: socket, assignment: Assignment) -> None:
        self._link, self._lease, self._app = link, assignment.lease, assignment.app
        clock = MonotonicClock()
        self._workers = [CutoffWorker(spec, clock) for spec in assignment.cutoffs]
        self._arming_s = ARMING_S + max(spec.extra_lease_s for spec in assignment.cutoffs)
        self._is_armed = False

    def run(self) -> None:
        """Open the cutoffs, report the result to the app, and guard the motors until the app ends."""
        opened = self._run_all("open", OPENING_S)
        self._send(opened.to_line())
        has_crashed = not opened.failed and not self._serve()
        stops = self._run_all("stop", STOPPING_S) if has_crashed else None
        self._run_all("close", STOPPING_S)
        if stops:  # at the end, because a full pipe at stderr blocks
            _log_crash(self._app, stops)

    def _serve(self) -> bool:
        # Returns whether the app sent `END`. Without it, the app's process has died.
        while True:
            self._link.settimeout(self._lease if self._is_armed else None)
            try:
                received = receive(self._link)
            except TimeoutError:
                self._is_armed = False
                self._send((stops := self._run_all("stop", STOPPING_S)).to_line())
                if warnings := _warnings(stops):  # a suspended app may never read the report, so print it
                    with suppress(ResourceError):  # in another thread, because a full pipe at stderr blocks
                        start_thread(partial(_log, warnings), "log")
                continue
            if not received or received.endswith(END):
                return bool(received)
            self._send(b"\n")
            self._update_lease(is_driving=received.endswith(BEGIN_LEASE))

    def _update_lease(self, *, is_driving: bool) -> None:
        if is_driving != self._is_armed:
            changed = self._run_all("arm" if is_driving else "disarm", self._arming_s)
            if changed.failed:
                self._send(changed.to_line())
        self._is_armed = is_driving

    def _run_all(self, action: Action, limit: float) -> GuardianReply:
        return run_all(self._workers, action, limit)

    def _send(self, line: bytes) -> None:
        with suppress(OSError):  # the app is gone: the next read ends the run
            self._link.sendall(line)


def _log_crash(app: int, stops: GuardianReply) -> None:
    stopped = f"process {app} ended during its run. Stopped: {', '.join(stops.done) or 'nothing'}"
    _log([*([stopped] if stops.done or stops.failed else []), *stops.messages, *_warnings(stops)])


def _warnings(stops: GuardianReply) -> list[str]:
    return [f"CANNOT STOP {device}. Cut the motors' supply" for device in stops.failed]


def _log(lines: Iterable[str]) -> None:
    # Past the buffer of `sys.stderr`, whose lock another thread may hold in a blocked write. Without `sys.stderr`, its
    # file descriptor may be that of a port.
    if sys.stderr:
        with suppress(OSError):
            os.write(sys.stderr.fileno(), "".join(f"guardian: {line}\n" for line in lines).encode())


LIMIT_S = 10.0
"""The time limit for each action of `stop_once`, in seconds. It is long, because a starting system is slow."""


def stop_once(specs: Iterable[CutoffSpec]) -> GuardianReply:
    """Open cutoffs, stop their motors, and close the cutoffs. Return a report of the stopped and the failed devices.

    A cutoff that fails or hangs does not delay the others, and no exception is raised. If the system refuses threads,
    the cutoffs run one after the other. A cutoff that hangs then delays the next one.
    """
    clock = MonotonicClock()
    workers = [_make_worker(spec, clock) for spec in merge_cutoffs(specs)]
    opened = run_all(workers, "open", LIMIT_S)
    ready = [worker for worker in workers if worker.device in opened.done]
    stopped = run_all(ready, "stop", LIMIT_S)
    run_all(workers, "close", LIMIT_S)
    return GuardianReply("stop", stopped.done, (*opened.failed, *stopped.failed), stopped.messages)


def _make_worker(spec: CutoffSpec, clock: Clock) -> CutoffWorker:
    try:
        return CutoffWorker(spec, clock)
    except ResourceError:
        return CutoffWorker(spec, clock, runs_in_caller_thread=True)
