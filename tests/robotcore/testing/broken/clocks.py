from __future__ import annotations

from dataclasses import replace

from robotcore.hal.robot import Robot
from tests.robotcore.testing.harness import broken, swap_in


def one_step_late(robot: Robot) -> None:
    robot.clock.sleep_until(1 / 240)


def ending_early(robot: Robot) -> None:
    sleep_until = robot.clock.sleep_until
    swap_in(robot.clock, "sleep_until", lambda deadline: sleep_until(deadline - 0.005))


def going_back(robot: Robot) -> None:
    """Show a second too little after the fourth sleep."""
    now, sleep_until = robot.clock.now, robot.clock.sleep_until
    sleeps: list[float] = []

    def sleep(deadline: float) -> bool:
        sleeps.append(deadline)
        return sleep_until(deadline)

    swap_in(robot.clock, "sleep_until", sleep)
    swap_in(robot.clock, "now", lambda: now() - (1.0 if len(sleeps) == 4 else 0.0))


def forgetting_calls(robot: Robot) -> None:
    swap_in(robot.clock, "call_at", lambda deadline, callback: None)


BROKEN = (
    broken("time begins before the opening", "time_begins_at_zero", one_step_late),
    broken("the clock is set back", "time_never_goes_back steps_divide_the_tick", going_back),
    broken(
        "sleep ends early",
        "sleeping_ends_no_earlier_than_asked steps_divide_the_tick",
        ending_early,
    ),
    broken(
        "the physics step is 1/240 s at every rate",
        "steps_divide_the_tick",
        setup_for=lambda setup: replace(setup, rate_hz=20.0),
    ),
    broken("calls are forgotten", "calls_are_made_when_they_are_due", forgetting_calls),
)
