"""Stop motors on GPIO lines from the guardian's process, by a board's standby line or by its input lines."""

from __future__ import annotations

import os
import signal
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from select import select

from drivers.raspberrypi.chip import Chip, HeldLineError
from robotcore.hal.cutoff import Cutoff

RELEASE_S = 0.3
"""The longest time from the end of a process until the kernel has freed its GPIO lines, in seconds."""


class StandbyLine(Cutoff):
    """Stops the motors of a board by pulling its standby line low (TB6612: STBY, DRV8833: nSLEEP).

    The guardian's process holds this line, not the app's. So the guardian can stop the motors of an app that hangs. All
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

    def disarm(self) -> None:
        """Pull the standby line low when the app commands a stop.

        The app's software PWM alone may stop the motor one PWM cycle later. It never does so if the app is suspended
        during that cycle.
        """
        self.stop()

    def stop(self) -> None:
        self._chip.write(self._line, is_high=False)

    def close(self) -> None:
        self.stop()
        self._chip.close()


class MotorLines(Cutoff):
    """Stops a motor without a standby line by pulling its input lines low.

    The app's process, the owner, holds these lines. The guardian can claim them only after the owner has ended. If the
    owner hangs while the motor turns, the guardian kills the owner. Otherwise lgpio's PWM thread, which does not depend
    on Python, would continue to turn the motor. If the motor stands, the guardian does not kill the owner. The guardian
    holds the claimed lines low until the guardian ends.

    Without an owner, `stop` claims the free lines. It raises HeldLineError if a process holds any of the other lines.

    lines: the GPIO numbers of the motor.
    owner: the number of the process that holds the lines; None if `stop` must not kill a process.

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

    def disarm(self) -> None:
        self._is_turning = False

    def stop(self) -> str | None:
        try:
            self._chip.claim_low(self._lines)
        except HeldLineError:
            if self._owner is None:
                raise
            if self._is_turning:
                if not self._owner.is_ending():
                    self._report = f"killed process {self._pid}, which was silent while its motors turned"
                self._owner.kill()
            if self._owner.has_ended_within(RELEASE_S) or self._is_turning:
                self._chip.claim_low(self._lines)
        return self._report

    def close(self) -> None:
        self._chip.close()
        if self._owner:
            self._owner.close()


_FLAGS = 6
"""The index of the field ``flags`` after the name in /proc/PID/stat. Source: proc_pid_stat(5)."""

_IS_EXITING = 0x4
"""The flag PF_EXITING of a process that is ending. Source: Linux, include/linux/sched.h."""


class Owner:
    """A handle of the process that holds GPIO lines. It never refers to a later process with the same number."""

    def __init__(self, number: int) -> None:
        """Open a handle of the process ``number``; raises ProcessLookupError if there is no such process."""
        self._number = number
        self._handle = os.pidfd_open(number)

    def is_ending(self) -> bool:
        """Return whether the process is ending or has ended. Some of its threads may still run."""
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
        """Wait up to ``seconds``; return whether the process has ended and all its files are closed."""
        return bool(select([self._handle], [], [], seconds)[0])

    def close(self) -> None:
        os.close(self._handle)
