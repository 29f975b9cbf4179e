"""An app that logs values of each type, and prints."""

from __future__ import annotations

from dataclasses import dataclass

from robotcore import Behaviour, Robot, Role, Status


@dataclass
class LoggingApp(Behaviour):
    """Drives forward for some ticks, and logs and prints in each tick if ``is_logging`` is set."""

    ticks: int = 10
    is_logging: bool = True
    needs = frozenset({Role.DRIVE, Role.RANGE})

    def __post_init__(self) -> None:
        self.count = 0

    def step(self, robot: Robot) -> Status:
        self.count += 1
        distance = robot.range.read().distance
        if self.is_logging:
            robot.log("distance", distance, "m")
            robot.log("error", (float("nan"), float("-inf"), 1 / 3)[self.count % 3], "rad/s²")
            robot.log("count", self.count)
            robot.log("is_even", self.count % 2 == 0)
            if self.count == 4:
                robot.log("phase", "=nan\n\x1b[2J")
            print(f"tick {self.count}", end="\nat ")  # noqa: T201  a test reads it
            print(f"{distance:.1f} m\udc80\n")  # noqa: T201
        robot.drive.set_velocity(0.1, 0.0)
        return Status.SUCCESS if self.count == self.ticks else Status.RUNNING
