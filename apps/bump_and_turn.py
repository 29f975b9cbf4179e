"""Drive until a bumper is pressed, back off, turn away and drive on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from robotcore import Behaviour, Interval, Positive, Robot, Role, Status, Truth
from robotcore.kinds import Bumper


@dataclass
class BumpAndTurn(Behaviour):
    """Drives ahead, and turns away from each obstacle that a bumper touches, until it has touched several."""

    speed_m_s: Positive = 0.2
    """The velocity forward and backward."""
    turn_rad_s: Positive = 1.5
    """The turn rate, in rad/s."""
    back_m: Positive = 0.12
    """The distance by which the robot backs off."""
    turn_rad: Positive = 2.0
    """The angle of a turn."""
    bumps: Annotated[int, Interval(ge=1, le=100)] = 3
    """The number of bumps after which the robot stops."""

    needs = frozenset({Role.DRIVE, Bumper})
    turns_on_spot = True
    milestones = ("drive", "back", "turn")

    def __post_init__(self) -> None:
        self.state, self._count, self._side, self._until = "drive", 0, 1.0, 0.0

    def verify(self, truth: Truth) -> bool | None:
        return None if truth.contacts is None else truth.contacts >= self.bumps

    def step(self, robot: Robot) -> Status:
        now = robot.clock.now()
        pressed = [bumper for bumper in robot.all(Bumper) if bumper.read().is_pressed]
        if self.state == "drive" and pressed:
            self._count += 1
            if self._count == self.bumps:
                return Status.SUCCESS
            self._side = -1.0 if pressed[0].direction > 0 else 1.0  # to the right after a contact on the left
            self.state, self._until = "back", now + self.back_m / self.speed_m_s
        elif self.state == "back" and now >= self._until:
            self.state, self._until = "turn", now + self.turn_rad / self.turn_rad_s
        elif self.state == "turn" and now >= self._until:
            self.state = "drive"
        robot.drive.set_velocity(*self._choose_velocity())
        return Status.RUNNING

    def _choose_velocity(self) -> tuple[float, float]:
        if self.state == "drive":
            return self.speed_m_s, 0.0
        return (-self.speed_m_s, 0.0) if self.state == "back" else (0.0, self._side * self.turn_rad_s)


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("bump-and-turn")
