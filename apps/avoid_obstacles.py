"""The reflex of bubbleRob: drive on, and steer away the more, the nearer something is."""

from __future__ import annotations

from dataclasses import dataclass

from robotcore import Behaviour, Positive, Robot, Role, Status


@dataclass
class AvoidObstacles(Behaviour):
    """Wanders without touching anything, until ``duration_s`` has passed."""

    speed_m_s: Positive = 0.2
    turn_rad_s: Positive = 1.5
    near_m: Positive = 0.5
    duration_s: Positive = 10.0

    needs = frozenset({Role.DRIVE, Role.RANGE})
    milestones = ("cruise", "avoid")

    def step(self, robot: Robot) -> Status:
        distance = robot.range.read().distance
        closeness = min(1.0, 0.2 * self.near_m / distance) if distance < self.near_m else 0.0
        self.state = "avoid" if closeness else "cruise"
        ahead = self.speed_m_s * (1 - closeness) if distance > self.near_m / 2 else 0.0
        robot.drive.set_velocity(ahead, self.turn_rad_s * min(1.0, 2 * closeness))
        return Status.SUCCESS if robot.clock.now() >= self.duration_s else Status.RUNNING


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("avoid-obstacles")
