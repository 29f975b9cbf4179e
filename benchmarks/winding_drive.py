"""An app that drives a winding way of 5 m, for `python -m benchmarks.fidelity`."""

from __future__ import annotations

import math
from typing import ClassVar

from robotcore import Behaviour, Robot, Role, Status
from robotcore.autonomy.routines import Routine

SPEED_M_S, TURN_RAD_S, SPOT_S = 0.2, 0.9, 1.5


class WindingDrive(Behaviour):
    """Drives 5 m: curves to both sides, turns on the spot, and a part of the way backward."""

    needs: ClassVar = {Role.DRIVE}
    parts: ClassVar = [
        (1.0, 0.0),
        (0.6, 1.0),
        (0.0, -1.0),
        (0.8, -1.0),
        (-0.6, 0.5),
        (0.0, 1.0),
        (1.0, 0.4),
        (-0.4, 0.0),
        (0.6, -0.6),
    ]
    """The way in metres, and the turn rate as a share of `TURN_RAD_S`. A turn on the spot takes `SPOT_S`."""

    def run(self, robot: Robot) -> Routine[Status]:
        for way, turn in self.parts:
            until = robot.clock.now() + (abs(way) / SPEED_M_S or SPOT_S)
            while robot.clock.now() < until:
                robot.drive.set_velocity(math.copysign(SPEED_M_S, way) if way else 0.0, turn * TURN_RAD_S)
                yield
        return Status.SUCCESS
