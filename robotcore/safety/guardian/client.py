"""The guardian as the app's process uses it: starts the process, renews its lease, reads its reports."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from socket import MSG_DONTWAIT, SHUT_WR, socket, socketpair
from subprocess import DEVNULL, Popen, TimeoutExpired
from types import TracebackType

from robotcore.errors import GuardianError
from robotcore.hal.cutoff import CutoffSpec, shared
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.guardian.protocol import BYE, DRIVING, RESTING, Assignment, LineBuffer, Report, read_line, receive

MIN_RENEWAL_S = 0.005
"""A lease that is younger is not begun again: a drive has more than one motor, an app may command one in a loop."""

START_TIMEOUT_S = 20.0
"""Longer than a guardian gives its cutoffs to open, which it can tell better."""

ANSWER_TIMEOUT_S = 2.0
"""Longer than a guardian takes for a stop that hangs."""

EXIT_TIMEOUT_S = 3.0
"""Longer than a guardian takes for a stop and a closing that hang."""

_RUN_STOPPED = "Every motor was stopped: nobody would stop them if this process could not. Start the run again"
_NOT_STARTED = "Nothing has moved: nobody would stop the motors if this process could not"

_DEATH_TIMEOUT_S = 0.1
"""The motors are stopped after it is known how it died."""

_STDERR = 2
_CODE = "import sys; sys.path[:] = sys.argv[2:]; from robotcore.safety.guardian.process import main; main()"
"""Not ``-m``: a signal.py in the folder in which somebody works must not stand in for Python's."""


class Guardian:
    """A process that stops motors when this one falls silent.

    A context: left in good order, it is dismissed; left by an exception, it stops the motors.

    It is a fresh interpreter in a session of its own, so that neither the state of a vendor's library nor a signal to
    the terminal's processes goes over to it.
    """

    def __init__(self, cutoffs: Sequence[CutoffSpec], lease: float) -> None:
        """Start it, and wait until it is ready. Raises GuardianError where it does not come up."""
        self._clock = MonotonicClock()
        self._lines = LineBuffer()
        self._unanswered_since: float | None = None
        self._driving_since: float | None = None
        self._failure: GuardianError | None = None
        self._link, theirs = socketpair()
        with theirs:
            self._process = _start_process(self._link, theirs)
        try:
            os.register_at_fork(after_in_child=self._link.close)  # a copy of this process would hide its end
            self._assign(Assignment(os.getpid(), lease, shared(cutoffs)))
        except BaseException:
            self._end(0.0)
            raise

    def renew_lease(self) -> bool:
        """Begin a lease before a motor turns; return False if the last lease is too young to be renewed.

        Never waits. Raises GuardianError if the guardian is gone; then the motor must not be commanded.
        """
        if self._failure:
            raise self._failure
        now = self._clock.now()
        if self._driving_since is not None and now - self._driving_since < MIN_RENEWAL_S:
            return False
        try:
            self._link.send(DRIVING, MSG_DONTWAIT)
        except BlockingIOError:
            raise self._failed("does not listen") from None
        except OSError:
            raise self._died() from None
        self._driving_since = now
        if self._unanswered_since is None:
            self._unanswered_since = now
        return True

    def end_lease(self) -> None:
        """End the lease, for every motor stands."""
        self._driving_since = None
        with suppress(OSError):  # the next `renew_lease` raises
            self._link.send(RESTING, MSG_DONTWAIT)

    def stops(self) -> list[Report]:
        """Return the stops that it has made since it was asked last. Never waits.

        Raises GuardianError where it has died, does not answer, or could not do its work.
        """
        if self._failure:
            raise self._failure
        reports = [Report.from_line(line) for line in self._lines.of(self._receive()) if line]
        if faults := [f"could not {report.deed} {fault}" for report in reports for fault in report.failed]:
            raise self._failed("; ".join(faults))
        return reports

    def _receive(self) -> bytes:
        """Return what has come by now."""
        try:
            said = receive(self._link, MSG_DONTWAIT)
        except BlockingIOError:
            self._require_patience()
            return b""
        if not said:
            raise self._died()
        self._unanswered_since = None
        return said

    def _require_patience(self) -> None:
        since, now = self._unanswered_since, self._clock.now()
        if since is not None and now - since > ANSWER_TIMEOUT_S:
            raise self._failed(f"has not answered for {now - since:.1f} s")

    def __enter__(self) -> Guardian:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Let it go, or where something was raised let it stop the motors and go; leave no process behind."""
        with suppress(OSError):
            if error is None:
                self._link.send(BYE, MSG_DONTWAIT)
            self._link.shutdown(SHUT_WR)
        self._end(EXIT_TIMEOUT_S)

    def _assign(self, assignment: Assignment) -> None:
        """Tell it what to guard, and wait until it can."""
        try:
            line = assignment.to_line()
        except TypeError as error:
            raise GuardianError(f"the guardian takes plain data alone: {error}. Mend the driver's cutoffs") from error
        self._link.settimeout(START_TIMEOUT_S)
        try:
            self._link.sendall(line)
            opened = Report.from_line(read_line(self._link))
        except TimeoutError:
            raise self._failed(f"is not ready within {START_TIMEOUT_S:g} s", _NOT_STARTED) from None
        except (EOFError, OSError):
            raise self._died(_NOT_STARTED) from None
        if opened.failed:
            raise self._failed(f"cannot open {'; '.join(opened.failed)}", _NOT_STARTED)
        self._link.settimeout(None)

    def _died(self, so: str = _RUN_STOPPED) -> GuardianError:
        with suppress(TimeoutExpired):
            self._process.wait(_DEATH_TIMEOUT_S)
        status = self._process.returncode
        killed = status is not None and status < 0
        how = signal.strsignal(-status) if killed else f"exit status {status}"
        return self._failed(f"died ({how})", so)

    def _failed(self, fault: str, so: str = _RUN_STOPPED) -> GuardianError:
        self._failure = GuardianError(f"the guardian process {self._process.pid} {fault}. {so}")
        return self._failure

    def _end(self, timeout_s: float) -> None:
        """See it go within this time, or end it."""
        try:
            self._process.wait(timeout_s)
        except TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._link.close()


def _start_process(ours: socket, theirs: socket) -> Popen[bytes]:
    """Start the process with its end of the link; it has nothing to read, and what it prints is no result of a run."""
    try:
        return Popen(  # noqa: S603  this very Python
            [sys.executable, "-c", _CODE, str(theirs.fileno()), *sys.path],
            stdin=DEVNULL,
            stdout=_STDERR,
            pass_fds=[theirs.fileno()],
            start_new_session=True,
        )
    except OSError as error:
        ours.close()
        raise GuardianError(f"no guardian process can be started: {error.strerror}. {_NOT_STARTED}") from error
