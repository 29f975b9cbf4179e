"""How the guardian makes motors on GPIO lines stand: by a line that it holds itself, or by those of the app's."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.raspberrypi.chip import Chip, HeldError
from drivers.raspberrypi.owner import Owner
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
        self._told: str | None = None

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
        return self._told

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
            self._told = f"ended process {self._pid}: it was silent, and held the lines of motors that turned"
        owner.kill()
