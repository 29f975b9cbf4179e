"""The AVR's time as a robot's clock."""

from __future__ import annotations

from robotcore.hal.wall_clock import FollowingClock
from tests.system.firmware.simulated import SimulatedRobot


class AskedClock(FollowingClock):
    """Asks for as much of the AVR's time as somebody sleeps: a busy program finds hardly any gone.

    Threads that wait beside the sleeper get theirs meanwhile; when all wait but nobody sleeps, the AVR creeps on.
    """

    def __init__(self, simulated: SimulatedRobot) -> None:
        super().__init__(simulated.now)
        self._simulated = simulated
        self._asked = simulated.now()
        simulated.ask_until(self._asked)

    def sleep_until(self, deadline: float) -> bool:
        self._asked = max(self._asked, self._zero + deadline)
        self._simulated.ask_until(self._asked)
        return super().sleep_until(deadline)
