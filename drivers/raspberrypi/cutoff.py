"""Cutoffs of motors on GPIO lines: the guardian pulls down a standby line of its own, or the lines of the app."""

from __future__ import annotations

import os
import signal
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from select import select

from drivers.raspberrypi.chip import Chip, HeldError
from robotcore.hal.cutoff import Cutoff

GOING_S = 0.3
"""A process that ends has let its lines go by then."""


class StandbyLine(Cutoff):
    """The standby or sleep line of a motor driver's chip (STBY of a TB6612, nSLEEP of a DRV8833): low, nothing turns.

    The guardian alone holds it, so that it falls whatever the app's process does. Motors with a chip in common name the
    same line.
    """

    def __init__(self, line: int) -> None:
        self._line = line

    def open(self) -> None:
        self._chip = Chip()
        self._chip.claim_low([self._line])

    def arm(self) -> None:
        self._chip.write(self._line, is_high=True)

    def rest(self) -> None:
        """Let it fall: software PWM may be late by a cycle, and its process suspended before that is over."""
        self.stop()

    def stop(self) -> None:
        self._chip.write(self._line, is_high=False)

    def close(self) -> None:
        self.stop()
        self._chip.close()


class MotorLines(Cutoff):
    """The input lines of a motor driver's chip that has no standby line, claimed by the app's process, the ``owner``.

    They can be had when that process has ended. One that lives while it should have been heard of, and has left motors
    turning, is ended for it: software PWM is a thread of its own in C, which goes on whatever hangs. One whose motors
    stand is left alone. The lines are low from then on; they are the guardian's as long as it lives.

    Without an ``owner`` nobody is ended: `stop` takes the lines that are free, and raises HeldError for the others.
    """

    def __init__(self, lines: Sequence[int], owner: int | None) -> None:
        self._lines, self._pid = lines, owner
        self._is_turning = False
        self._report: str | None = None

    def open(self) -> None:
        self._chip = Chip()
        self._owner = None if self._pid is None else Owner(self._pid)

    def arm(self) -> None:
        self._is_turning = True

    def rest(self) -> None:
        self._is_turning = False

    def stop(self) -> str | None:
        try:
            self._chip.claim_low(self._lines)
        except HeldError:
            if self._owner is None:
                raise
            self._claim_from(self._owner)
        return self._report

    def close(self) -> None:
        self._chip.close()
        if self._owner:
            self._owner.close()

    def _claim_from(self, owner: Owner) -> None:
        """Have the owner end, where it must, and claim its lines."""
        if self._is_turning:
            self._end(owner)
        if owner.has_ended_within(GOING_S) or self._is_turning:
            self._chip.claim_low(self._lines)

    def _end(self, owner: Owner) -> None:
        """End the owner; what it does by itself already, is not told."""
        if not owner.is_ending():
            self._report = f"ended process {self._pid}: it was silent, and held the lines of motors that turned"
        owner.kill()


_FLAGS = 6
"""Where /proc/PID/stat has the flags of a process, counted from behind its name. Source: proc_pid_stat(5)."""

_IS_EXITING = 0x4
"""PF_EXITING. Source: Linux, include/linux/sched.h."""


class Owner:
    """A process of another's, and never the one that gets its number later."""

    def __init__(self, number: int) -> None:
        """Take hold of a process that lives; ProcessLookupError where it does not."""
        self._number = number
        self._handle = os.pidfd_open(number)

    def is_ending(self) -> bool:
        """Return whether its end has begun, for whatever reason; threads of it may still be at work."""
        if self.has_ended_within(0.0):
            return True
        try:
            stat = Path(f"/proc/{self._number}/stat").read_text()
        except (FileNotFoundError, ProcessLookupError):
            return True
        return bool(int(stat.rpartition(")")[2].split()[_FLAGS]) & _IS_EXITING)

    def kill(self) -> None:
        """End it, also one that is suspended or hangs."""
        with suppress(ProcessLookupError):
            signal.pidfd_send_signal(self._handle, signal.SIGKILL)

    def has_ended_within(self, seconds: float) -> bool:
        """Return whether it has ended, all its files closed, after waiting no longer than this."""
        return bool(select([self._handle], [], [], seconds)[0])

    def close(self) -> None:
        os.close(self._handle)
