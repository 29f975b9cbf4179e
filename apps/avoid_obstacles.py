"""Drive forward, and turn away from obstacles. The robot turns faster if an obstacle is nearer."""

from __future__ import annotations

from dataclasses import dataclass

from robotcore import Behaviour, Positive, Robot, Role, Status


@dataclass
class AvoidObstacles(Behaviour):
    """Drives without touching obstacles for a given time."""

    speed_m_s: Positive = 0.2
    """The greatest velocity forward."""
    turn_rad_s: Positive = 1.5
    """The greatest velocity of a turn."""
    near_m: Positive = 0.5
    """The distance of an obstacle at which the robot begins to turn."""
    duration_s: Positive = 10.0
    """The duration of the run."""

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
