"""Stop motors on GPIO lines from the guardian process: by a board's standby line, or by the app's own lines."""

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
"""The longest time, in seconds, from the killing of a process until the kernel has freed its GPIO lines."""


class StandbyLine(Cutoff):
    """Pulls down the standby line of a motor board (STBY of a TB6612, nSLEEP of a DRV8833), so that its motors stop.

    Only the guardian's process holds this line, so it can pull it low whatever state the app's process is in. All
    motors on one board have the same standby line.

    >>> StandbyLine(22)
    <StandbyLine GPIO 22>
    """

    def __init__(self, line: int) -> None:
        self._line = line

    def __repr__(self) -> str:
        return f"<StandbyLine GPIO {self._line}>"

    def open(self) -> None:
        self._chip = Chip()
        self._chip.claim_low([self._line])

    def arm(self) -> None:
        self._chip.write(self._line, is_high=True)

    def rest(self) -> None:
        """Pull the standby line low when the app commands a stop.

        The app's software PWM may stop the motor a cycle later, or never if the app is suspended before that.
        """
        self.stop()

    def stop(self) -> None:
        self._chip.write(self._line, is_high=False)

    def close(self) -> None:
        self.stop()
        self._chip.close()


class MotorLines(Cutoff):
    """Pulls down the input lines of a motor board without a standby line. The app's process holds these lines.

    The guardian can claim the lines only after that process, the owner, has ended. If the owner hangs while its motors
    turn, the guardian kills the owner, because the software PWM is a thread in C that continues if Python hangs. If the
    motors stand, the guardian does not kill the owner. The guardian holds the claimed lines low until it ends itself.

    Without an owner, `stop` claims the free lines, and raises HeldError if any other line is held by a process.

    lines: the GPIO numbers of the motor.
    owner: the process that holds the lines; None if there is none to kill.

    >>> MotorLines([17, 27], owner=None)
    <MotorLines GPIO 17, 27, at rest>
    """

    def __init__(self, lines: Sequence[int], owner: int | None) -> None:
        self._lines, self._pid = lines, owner
        self._is_turning = False
        self._report: str | None = None

    def __repr__(self) -> str:
        lines = ", ".join(map(str, self._lines))
        return f"<MotorLines GPIO {lines}, {'turning' if self._is_turning else 'at rest'}>"

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
        """Claim the owner's lines. If the motors turn, kill the owner first."""
        if self._is_turning:
            self._end(owner)
        if owner.has_ended_within(GOING_S) or self._is_turning:
            self._chip.claim_low(self._lines)

    def _end(self, owner: Owner) -> None:
        """Kill the owner. Report this, unless the owner was already ending."""
        if not owner.is_ending():
            self._report = f"ended process {self._pid}: it was silent while its motors turned"
        owner.kill()


_FLAGS = 6
"""The index of the field ``flags`` among the fields of /proc/PID/stat after the name. Source: proc_pid_stat(5)."""

_IS_EXITING = 0x4
"""The flag PF_EXITING of a process that is ending. Source: Linux, include/linux/sched.h."""


class Owner:
    """A handle of another process. It never refers to a later process that gets the same process number."""

    def __init__(self, number: int) -> None:
        """Open a handle of a process; raises ProcessLookupError if there is no such process."""
        self._number = number
        self._handle = os.pidfd_open(number)

    def is_ending(self) -> bool:
        """Return whether the process is ending or has ended; some of its threads may still run."""
        if self.has_ended_within(0.0):
            return True
        try:
            stat = Path(f"/proc/{self._number}/stat").read_text()
        except (FileNotFoundError, ProcessLookupError):
            return True
        return bool(int(stat.rpartition(")")[2].split()[_FLAGS]) & _IS_EXITING)

    def kill(self) -> None:
        """Kill the process, even if it is suspended or hangs."""
        with suppress(ProcessLookupError):
            signal.pidfd_send_signal(self._handle, signal.SIGKILL)

    def has_ended_within(self, seconds: float) -> bool:
        """Wait up to this long; return whether the process has ended and closed all its files."""
        return bool(select([self._handle], [], [], seconds)[0])

    def close(self) -> None:
        os.close(self._handle)
