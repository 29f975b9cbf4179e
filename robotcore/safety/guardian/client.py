"""The app's side of the guardian: it starts the process, renews the lease, and reads the reports."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from socket import SHUT_WR, socket
from subprocess import DEVNULL, Popen, TimeoutExpired
from types import TracebackType

from robotcore.child_process import start_linked_process
from robotcore.errors import GuardianError
from robotcore.hal.cutoff import CutoffSpec, merge_cutoffs
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.guardian.protocol import (
    BEGIN_LEASE,
    END,
    END_LEASE,
    Assignment,
    GuardianReply,
    LineBuffer,
    read_line,
    receive,
)
from robotcore.safety.real_time import set_process_priority
from robotcore.system import HAS_POSIX

MIN_RENEWAL_S = 0.005
"""The shortest time in seconds between two renewals of the lease.

A drive commands several motors in a tick, and one renewal is sufficient for all of them.
"""

START_TIMEOUT_S = 20.0
"""The time limit for the start of the guardian, in seconds.

The guardian's own limit for opening cutoffs is shorter, so that its report contains the cutoff that failed.
"""

ANSWER_TIMEOUT_S = 2.0
"""The time limit for an answer of the guardian, in seconds. The guardian's own limit for a stop is shorter."""

EXIT_TIMEOUT_S = 3.0
"""The time limit for the guardian's end, in seconds. The guardian's limits for a stop and a close are shorter."""

_RUN_STOPPED = "Every motor was stopped, because only a guardian can stop them if the app hangs. Start the run again"
_MAY_TURN = "A motor that was not stopped may still turn. Switch off its power, and repair it before the next run"
_NOT_STARTED = "No motor has turned, because only a guardian can stop the motors if the app hangs"

_DEATH_TIMEOUT_S = 0.1
"""The longest wait for the exit status of a dead guardian, in seconds. The motors are stopped after this wait."""

_STDERR = 2
_CODE = "import sys; sys.path[:] = sys.argv[2:]; from robotcore.safety.guardian.process import main; main()"
"""The code that the guardian process runs. Its first argument is the address of the link.

With ``python -m``, a file such as signal.py in the working directory would replace Python's module.
"""


class Guardian:
    """A process that stops the motors if this process dies or does not renew the lease in time.

    It is a context manager. The guardian ends after the context. If the context raises, the guardian stops the motors
    first.

    The guardian is a new Python interpreter, so it inherits no state of a vendor's library. It has its own session, so
    it gets no signals from the terminal.
    """

    def __init__(self, cutoffs: Sequence[CutoffSpec], lease: float, priority: int | None = None) -> None:
        """Start the process, and wait until all cutoffs are open.

        cutoffs: the specifications of the cutoffs that stop the motors.
        lease: the time in seconds without a renewal after which the guardian stops the motors.
        priority: the real-time priority of the process; None for the normal priority.

        Raises GuardianError if the process does not start or a cutoff does not open.
        """
        self._clock = MonotonicClock()
        self._lines = LineBuffer()
        self._unanswered_since: float | None = None
        self._driving_since: float | None = None
        self._failure: GuardianError | None = None
        self._process, self._link = _start_process()
        try:
            if priority is not None:  # before the assignment, after which the process starts its threads
                self._set_priority(priority)
            if HAS_POSIX:
                os.register_at_fork(after_in_child=self._link.close)  # a copy in a fork would hide this process's end
            self._assign(Assignment(os.getpid(), lease, merge_cutoffs(cutoffs)))
        except BaseException:
            self._end(0.0)
            raise

    def __repr__(self) -> str:
        """Return the process number, and whether a motor turns."""
        state = "failed" if self._failure else "at rest" if self._driving_since is None else "driving"
        return f"<Guardian process {self._process.pid}: {state}>"

    def renew_lease(self) -> bool:
        """Renew the lease before a motor turns. Return False if the last renewal was less than `MIN_RENEWAL_S` ago.

        The method does not wait for an answer. Raises GuardianError if the guardian is gone. The caller must then not
        turn the motor.
        """
        if self._failure:
            raise self._failure
        now = self._clock.now()
        if self._driving_since is not None and now - self._driving_since < MIN_RENEWAL_S:
            return False
        try:
            self._link.send(BEGIN_LEASE)
        except BlockingIOError:
            raise self._fail("reads no commands", "guardian-overflow") from None
        except OSError:
            raise self._fail_dead() from None
        self._driving_since = now
        if self._unanswered_since is None:
            self._unanswered_since = now
        return True

    def end_lease(self) -> None:
        """End the lease. The caller must have stopped every motor."""
        self._driving_since = None
        with suppress(OSError):  # the next `renew_lease` raises
            self._link.send(END_LEASE)

    def stops(self) -> list[GuardianReply]:
        """Return the reports of the guardian's stops since the last call. The method does not wait.

        Raises GuardianError if the guardian died, does not answer, or failed to arm or stop a motor.
        """
        if self._failure:
            raise self._failure
        reports = [GuardianReply.from_line(line) for line in self._lines.add(self._receive()) if line]
        if failed := [(report.action, device) for report in reports for device in report.failed]:
            text = "; ".join(f"could not {action} {device}" for action, device in failed)
            is_stop = any(action == "stop" for action, _ in failed)
            raise self._fail(text, "guardian-action-failed", _MAY_TURN if is_stop else _RUN_STOPPED)
        return reports

    def _receive(self) -> bytes:
        try:
            data = receive(self._link)
        except BlockingIOError:
            since, now = self._unanswered_since, self._clock.now()
            if since is not None and now - since > ANSWER_TIMEOUT_S:
                raise self._fail(f"has not answered for {now - since:.1f} s", "guardian-silent") from None
            return b""
        if not data:
            raise self._fail_dead()
        self._unanswered_since = None
        return data

    def __enter__(self) -> Guardian:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """End the guardian process and wait for its end. After an exception, the guardian stops the motors first."""
        with suppress(OSError):
            if error is None:
                self._link.send(END)
            self._link.shutdown(SHUT_WR)
        self._end(EXIT_TIMEOUT_S)

    def _set_priority(self, priority: int) -> None:
        try:
            set_process_priority(self._process.pid, priority)
        except OSError as error:
            text = f"gets no real-time priority {priority}: {error.strerror}"
            raise self._fail(text, "guardian-priority", _NOT_STARTED) from error

    def _assign(self, assignment: Assignment) -> None:
        try:
            line = assignment.to_line()
        except TypeError as error:
            raise GuardianError(
                f"the parameters of a cutoff must be JSON data: {error}. Correct the driver's cutoffs",
                kind="cutoff-not-json",
            ) from error
        self._link.settimeout(START_TIMEOUT_S)
        try:
            self._link.sendall(line)
            opened = GuardianReply.from_line(read_line(self._link))
        except TimeoutError:
            raise self._fail(f"is not ready within {START_TIMEOUT_S:g} s", "guardian-late", _NOT_STARTED) from None
        except (EOFError, OSError):
            raise self._fail_dead(_NOT_STARTED) from None
        if opened.failed:
            raise self._fail(f"cannot open {'; '.join(opened.failed)}", "cutoff-not-opened", _NOT_STARTED)
        self._link.setblocking(False)

    def _fail_dead(self, consequence: str = _RUN_STOPPED) -> GuardianError:
        with suppress(TimeoutExpired):
            self._process.wait(_DEATH_TIMEOUT_S)
        status = self._process.returncode
        is_killed = status is not None and status < 0
        how = signal.strsignal(-status) if is_killed else f"exit status {status}"
        return self._fail(f"died ({how})", "guardian-died", consequence)

    def _fail(self, problem: str, kind: str, consequence: str = _RUN_STOPPED) -> GuardianError:
        # The error is stored, because every later call raises it again.
        process = self._process.pid
        self._failure = GuardianError(
            f"the guardian process {process} {problem}. {consequence}", kind=kind, process=process
        )
        return self._failure

    def _end(self, timeout_s: float) -> None:
        try:
            self._process.wait(timeout_s)
        except TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._link.close()


def _start_process() -> tuple[Popen[bytes], socket]:
    # The output of the process goes to stderr, because stdout contains the run's result.
    try:
        return start_linked_process(_CODE, sys.path, stdout=_STDERR if sys.stderr else DEVNULL, is_detached=True)
    except OSError as error:
        raise GuardianError(
            f"no guardian process can be started: {error.strerror}. {_NOT_STARTED}", kind="guardian-not-started"
        ) from error
