"""An app that drives random manoeuvres, composed in several ways. The benchmark of replays records it."""

from __future__ import annotations

import random
from dataclasses import dataclass

from robotcore import (
    Behaviour,
    Robot,
    Role,
    Routine,
    Status,
    arc,
    errors,
    move,
    on_stop,
    parallel,
    race,
    repeat,
    straight,
    turn,
    until,
    wait,
    with_timeout,
)


@dataclass
class RandomManoeuvres(Behaviour):
    """Drives manoeuvres that ``seed`` draws, until the run ends. After a BlockedError it drives back."""

    seed: int = 1

    needs = frozenset({Role.DRIVE, Role.RANGE})

    def run(self, robot: Robot) -> Routine[Status]:
        draw = random.Random(self.seed)
        yield from repeat(lambda: self._drive_on(robot, draw))
        return Status.FAILURE

    def _drive_on(self, robot: Robot, draw: random.Random) -> Routine[None]:
        try:
            yield from on_stop(self._drive(robot, draw), lambda: robot.drive.set_velocity(0.0, 0.0))
        except errors.BlockedError as error:
            self.state = f"blocked by {error.cause}"
            yield from race(move(robot, -0.1, draw.uniform(-0.5, 0.5)), wait(robot, 0.5))
        except TimeoutError:
            self.state = "timeout"

    def _drive(self, robot: Robot, draw: random.Random) -> Routine[None]:
        self.state = draw.choice(("straight", "turn", "arc", "until", "parallel"))
        length, angle = draw.uniform(-0.2, 0.6), draw.uniform(-2, 2)
        if self.state == "straight":
            yield from with_timeout(robot, 1.5, straight(robot, length))
        elif self.state == "turn":
            yield from turn(robot, angle)
        elif self.state == "arc":
            yield from arc(robot, abs(length) + 0.1, angle)
        elif self.state == "until":
            yield from until(lambda: robot.range.read().distance < 0.5, move(robot, 0.2, seconds=1.0))
        else:
            yield from parallel(move(robot, 0.1, angle, seconds=0.4), wait(robot, 0.6))
