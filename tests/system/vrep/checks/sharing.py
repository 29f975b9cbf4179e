"""Checks of sharing a simulator: a second program, Ctrl-C, and the server of a running scene."""

from __future__ import annotations

import signal
from collections.abc import Callable

import pytest

from drivers.vrep.wire.errors import RemoteApiError
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.trace import TickRecord
from tests.system import rolling
from tests.system.vrep import scenes
from tests.system.vrep.checks.driving import read_angle
from tests.system.vrep.server import is_running, open_rover, run_on, start_client


class Once:
    """An observer that calls an action in the third tick of a run."""

    def __init__(self, action: Callable[[], object]) -> None:
        self._action, self._left = action, 3

    def begin(self, run: object) -> None:
        """Do nothing."""

    def tick(self, record: TickRecord) -> None:
        self._left -= 1
        if self._left == 0:
            self._action()

    def end(self, result: RunResult) -> None:
        """Do nothing."""


def test_second_program_is_refused_and_the_first_continues() -> None:
    second: list[RunResult] = []
    with scenes.relay():
        first = run_on("mark-green", Once(lambda: second.append(run_on("mark-green"))))
        assert first.outcome is Outcome.SUCCESS, first.reason
        assert second[0].exit_status == 3
        assert isinstance(second[0].error, RemoteApiError)
        assert second[0].error.kind == "port-in-use"
        again = run_on("mark-green")
        assert again.outcome is Outcome.SUCCESS, again.reason


@pytest.mark.parametrize("stepped", [True, False])
def test_ctrl_c_stops_the_simulation(*, stepped: bool) -> None:
    with scenes.relay():
        interrupt = Once(lambda: signal.raise_signal(signal.SIGINT))
        result = run_on("mark-green", interrupt, duration_s=600.0, more={"stepped": stepped})
        assert (result.outcome, result.exit_status) == (Outcome.INTERRUPTED, 128 + signal.SIGINT)
        with start_client() as number:
            assert not is_running(number)


def test_server_of_a_running_scene_can_be_joined(unused_port: int) -> None:
    with scenes.rover(), scenes.running():
        scenes.serve(unused_port)
        with open_rover(*rolling.MOTORS, "left_encoder", port=unused_port, stepped=False) as robot:
            assert robot.truth
            start, start_s = robot.truth.pose(), robot.clock.now()
            for motor in robot.motors.values():
                motor.set_velocity(4.0)
            for tick in range(1, 41):  # an encoder must be read at least once in half a turn
                robot.clock.sleep_until(start_s + tick * 0.05)
                counted = read_angle(robot, "left_encoder")
            pose = robot.truth.pose()
        ahead, aside = start.to_local(pose.x, pose.y)
        assert ahead == pytest.approx(counted * rolling.RADIUS_M, abs=0.05)
        assert (ahead > 0.05, abs(aside) < 0.02) == (True, True), f"{ahead:.3f} m ahead, {aside:.3f} m aside"
