from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from robotcore.errors import (
    BehaviourError,
    DeviceError,
    UnknownNameError,
    UnmetNeedError,
    UsageError,
)
from robotcore.geometry import Wheels
from robotcore.hal.robot import Robot, Role
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.session import RunRequest, run
from robotcore.testing.mock.devices import LOST
from robotcore.testing.mock.robot import MockRobot
from tests.texts import Raises


@dataclass
class Ahead(Behaviour):
    """An app that drives forward for some ticks, and records the distances."""

    ticks: int = 1000
    linear: float = 0.05
    seen: list[float] = field(default_factory=list)

    needs = frozenset({Role.DRIVE, Role.RANGE})

    def step(self, robot: Robot) -> Status:
        self.seen.append(robot.range.read().distance)
        robot.drive.set_velocity(self.linear, 0.0)
        return Status.SUCCESS if len(self.seen) == self.ticks else Status.RUNNING


class Marking(Behaviour):
    """An app that shows every picture of the camera."""

    needs = frozenset({Role.CAMERA, Role.DISPLAY})

    def step(self, robot: Robot) -> Status:
        robot.display.show(robot.camera.read().image)
        return Status.RUNNING


class Undeclared(Behaviour):
    """An app that reads a camera and does not declare it in ``needs``."""

    needs = frozenset({Role.DRIVE})

    def step(self, robot: Robot) -> Status:
        robot.camera.read()
        return Status.RUNNING


def test_each_tick_has_one_reading_of_a_list_or_a_function() -> None:
    app = Ahead()
    MockRobot(range=[1.0, 0.9, 0.8]).run(app, ticks=5)
    assert app.seen == [1.0, 0.9, 0.8, 0.8, 0.8]
    MockRobot(range=lambda time: 1.0 - time).run(app, ticks=3)
    assert app.seen[5:] == pytest.approx([1.0, 0.95, 0.9])


@pytest.mark.parametrize("rate_hz", [3.0, 7.0, 20.0, 30.0, 50.0, 300.0])
def test_no_reading_is_left_out_at_any_rate(rate_hz: float) -> None:
    app, script = Ahead(), [1.0 + i / 100 for i in range(60)]
    MockRobot(range=script, rate_hz=rate_hz).run(app, ticks=60)
    assert app.seen == script


def test_lost_echo_leaves_the_last_sample() -> None:
    robot = MockRobot(range=[1.0, LOST, LOST, 0.5])
    samples = []
    for _ in range(4):
        samples.append(robot.layered.range.read())
        robot.advance()
    assert [sample.sequence for sample in samples] == [0, 0, 0, 1]
    assert [sample.time for sample in samples] == [0.0, 0.0, 0.0, 0.15]
    assert [sample.distance for sample in samples] == [1.0, 1.0, 1.0, 0.5]


def test_reading_that_was_not_read_counts_as_a_sample() -> None:
    robot = MockRobot(range=[1.0, 0.9, LOST])
    robot.advance(2)
    sample = robot.layered.range.read()
    assert (sample.distance, sample.time, sample.sequence) == (0.9, 0.05, 1)


def test_exception_in_a_script_fails_the_device_at_that_tick(raises: Raises) -> None:
    robot = MockRobot(range=[1.0, OSError("the wire is off"), 0.8])
    robot.run(Ahead())
    with raises(DeviceError) as caught:
        robot.run(Ahead())
    assert isinstance(caught.value.__cause__, OSError)
    robot.advance()
    assert robot.layered.range.read().distance == 0.8


def test_distances_keep_the_limits_of_the_sensor() -> None:
    app = Ahead(linear=0.0)
    MockRobot(range=[0.001, 2.5, math.inf]).run(app, ticks=3)
    assert app.seen == [0.02, math.inf, math.inf]


def test_range_guard_acts_as_in_a_real_run() -> None:
    robot = MockRobot(range=0.05)
    robot.run(Ahead(), ticks=1)
    assert robot.wheels == [Wheels(0.0, 0.0)]
    assert [change.cause for change in robot.ticks[0].interventions] == ["range guard"]


def test_deadman_stops_the_wheels_of_a_stalled_app() -> None:
    robot = MockRobot(range=1.0)
    robot.run(Ahead())
    robot.advance(5)
    (begun, driving), (cut, stopped) = robot.commands["left_motor"]
    assert (begun, stopped) == (0.0, 0.0)
    assert driving > 0
    assert cut == pytest.approx(0.125, abs=1 / 240)


def test_wheels_stop_at_the_end_of_the_app() -> None:
    robot = MockRobot(range=1.0)
    assert robot.run(Ahead(ticks=2), ticks=10) is Status.SUCCESS
    assert len(robot.ticks) == 2
    assert [robot.commands[name][-1].velocity for name in ("left_motor", "right_motor")] == [0.0, 0.0]


def test_odometry_follows_the_wheels() -> None:
    robot = MockRobot(range=1.0)
    assert robot.layered.drive.pose.x == 0
    robot.run(Ahead(linear=0.08), ticks=21)
    assert robot.layered.drive.pose.x == pytest.approx(0.08 * 21 / 20)


def test_encoder_may_be_scripted() -> None:
    robot = MockRobot(readings={"left_encoder": [0.0, 1.0], "right_encoder": [0.0, 1.0]})
    assert robot.layered.drive.pose.x == 0
    robot.advance()
    assert robot.layered.drive.pose.x == pytest.approx(0.0325)


def test_pictures_are_played_and_kept() -> None:
    black, white = (np.full((240, 320, 3), level, dtype=np.uint8) for level in (0, 255))
    robot = MockRobot(camera=[black, white])
    robot.run(Marking(), ticks=3)
    canvas = black.copy()
    robot.layered.display.show(canvas)
    canvas[:] = 99
    assert [picture[0, 0, 0] for picture in robot.pictures] == [0, 255, 255, 0]


def test_without_a_script_nothing_is_in_range_and_the_picture_is_grey() -> None:
    robot = MockRobot().layered
    assert robot.range.read().distance == math.inf
    assert (robot.camera.read().image == 128).all()


@pytest.mark.parametrize(
    "script, kind",
    [
        pytest.param({"range": [1.0, math.nan]}, "script-reading", id="nan"),
        pytest.param({"range": -0.1}, "script-reading", id="negative"),
        pytest.param({"range": ["near"]}, "script-reading", id="text"),
        pytest.param({"range": [None]}, "script-reading", id="None"),
        pytest.param({"range": []}, "script-empty", id="empty"),
        pytest.param({"camera": np.zeros((10, 10, 3), dtype=np.uint8)}, "script-reading", id="small picture"),
        pytest.param({"readings": {"left_encoder": math.inf}}, "script-reading", id="infinite angle"),
        pytest.param({"faults": "range drop=0.2"}, "wrong-type", id="no list"),
    ],
)
def test_wrong_argument_is_refused_at_once(script: dict[str, Any], kind: str, raises: Raises) -> None:
    with raises(UsageError, kind):
        MockRobot(**script)


def test_wrong_reading_of_a_function_is_refused_when_it_is_read(raises: Raises) -> None:
    with raises(BehaviourError):
        MockRobot(range=lambda time: -time).run(Ahead(), ticks=2)


def test_script_without_a_first_reading_fails_the_device(raises: Raises) -> None:
    with raises(DeviceError, "nothing-read"):
        MockRobot(range=LOST).run(Ahead())


def test_device_that_the_app_does_not_need_is_not_open(raises: Raises) -> None:
    with raises(BehaviourError):
        MockRobot().run(Undeclared())


def test_robot_without_a_drive_can_be_mocked() -> None:
    robot = MockRobot("lookout")
    robot.run(Marking(), ticks=2)
    assert len(robot.pictures) == 2
    assert robot.wheels == []


def test_script_for_a_device_that_is_not_there_is_refused(raises: Raises) -> None:
    with raises(UnmetNeedError, "no-device-for-script"):
        MockRobot("lookout", range=1.0)
    with raises(UnknownNameError, "unknown-scripted-sensor"):
        MockRobot(readings={"noes": 1.0})


def test_mock_runs_from_the_command_line_too() -> None:
    result = run(RunRequest("avoid-obstacles", backend="mock", settings={"duration_s": 0.5}))
    assert result.outcome.value == "success"
    assert result.verified is None
    assert result.ticks == 11


def test_faults_are_injected_and_depend_on_the_seed() -> None:
    def seen(seed: int) -> list[float]:
        app = Ahead()
        script = [1 + tick / 100 for tick in range(15)]
        MockRobot(range=script, faults=["range drop=0.5"], seed=seed).run(app, ticks=15)
        return app.seen

    assert seen(1) == seen(1) != seen(2)


def test_reason_that_is_no_text_is_an_error_as_in_a_real_run(raises: Raises) -> None:
    app = Ahead(ticks=1)
    app.reason = 5  # type: ignore[assignment]
    robot = MockRobot()
    with raises(BehaviourError, "reason-not-a-text"):
        robot.run(app)
    assert robot.commands["left_motor"][-1].velocity == 0.0


@pytest.mark.parametrize("ticks", [0, -5])
def test_run_without_a_tick_is_refused(ticks: int, raises: Raises) -> None:
    with raises(UsageError, "no-ticks", ticks=ticks):
        MockRobot().run(Ahead(), ticks=ticks)


def test_class_in_place_of_an_app_is_refused(raises: Raises) -> None:
    with raises(UsageError, "not-an-instance"):
        MockRobot().run(Ahead)  # type: ignore[arg-type]


class Logging(Behaviour):
    """An app that logs its distance."""

    needs = frozenset({Role.RANGE})

    def step(self, robot: Robot) -> Status:
        robot.log("distance", robot.range.read().distance, "m")
        return Status.RUNNING


def test_logged_values_can_be_tested() -> None:
    robot = MockRobot(range=[1.0, 0.5])
    robot.run(Logging(), ticks=2)
    assert robot.logged == {"distance": [1.0, 0.5]}
    assert robot.ticks[1].logged["distance"].unit == "m"
