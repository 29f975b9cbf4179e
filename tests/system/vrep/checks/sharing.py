"""A simulator that others use too: a second program, Ctrl-C, a service in a scene that runs by itself."""

from __future__ import annotations

import signal
from collections.abc import Callable

import pytest

from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.trace import TickRecord
from tests.system import rolling
from tests.system.vrep import scenes
from tests.system.vrep.checks.driving import angle
from tests.system.vrep.server import client, is_running, opened, run_on


class Once:
    """Does something in the third tick of a run."""

    def __init__(self, deed: Callable[[], object]) -> None:
        self._deed, self._left = deed, 3

    def begin(self, run: object) -> None:
        """Wait."""

    def tick(self, record: TickRecord) -> None:
        self._left -= 1
        if self._left == 0:
            self._deed()

    def end(self, result: RunResult) -> None:
        """Nothing more."""


def test_second_program_is_distinguished_and_the_first_goes_on() -> None:
    second: list[RunResult] = []
    with scenes.relay():
        first = run_on("mark-green", Once(lambda: second.append(run_on("mark-green"))))
        assert first.outcome is Outcome.SUCCESS, first.reason
        assert second[0].exit_status == 3
        assert "A port serves one program at a time" in second[0].reason
        again = run_on("mark-green")
        assert again.outcome is Outcome.SUCCESS, again.reason


@pytest.mark.parametrize("stepped", [True, False])
def test_ctrl_c_leaves_the_simulation_stopped(*, stepped: bool) -> None:
    with scenes.relay():
        interrupt = Once(lambda: signal.raise_signal(signal.SIGINT))
        result = run_on("mark-green", interrupt, duration_s=600.0, more={"stepped": stepped})
        assert (result.outcome, result.reason) == (Outcome.INTERRUPTED, "interrupted by SIGINT")
        with client() as number:
            assert not is_running(number)


def test_service_of_a_scene_that_runs_is_followed(unused_port: int) -> None:
    with scenes.rover(), scenes.running():
        scenes.serve(unused_port)
        with opened(*rolling.MOTORS, "left_encoder", port=unused_port, stepped=False) as robot:
            assert robot.truth
            start, begun = robot.truth.pose(), robot.clock.now()
            for motor in robot.motors.values():
                motor.set_velocity(4.0)
            for tick in range(1, 41):  # an encoder that nobody reads for half a turn loses count
                robot.clock.sleep_until(begun + tick * 0.05)
                counted = angle(robot, "left_encoder")
            pose = robot.truth.pose()
        ahead, aside = start.to_local(pose.x, pose.y)
        assert ahead == pytest.approx(counted * rolling.RADIUS_M, abs=0.05)
        assert (ahead > 0.05, abs(aside) < 0.02) == (True, True), f"{ahead:.3f} m ahead, {aside:.3f} m aside"
