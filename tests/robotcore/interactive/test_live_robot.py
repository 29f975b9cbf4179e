"""A robot at a prompt: its calls let time pass, and between two calls the wheels stand."""

from __future__ import annotations

import math
import os
import signal
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from traceback import extract_tb, format_exception
from typing import Any

import pytest

import robotcore
from robotcore import Behaviour, LiveRobot, Outcome, Robot, Role, Routine, Status
from robotcore.errors import (
    BehaviourError,
    BlockedError,
    DeviceClosedError,
    DeviceError,
    InvalidCommandError,
    RecordingError,
    RoutineTimeoutError,
    UnknownNameError,
    UnmetNeedError,
    UsageError,
)
from robotcore.hal.clock import SteppedClock
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.camera import Camera
from robotcore.recording import read
from robotcore.runtime.session import RunSession
from tests.texts import Raises


@pytest.fixture
def robot() -> Iterator[LiveRobot]:
    with robotcore.open("rover", world="open") as opened:
        yield opened


def test_first_session_of_the_readme(robot: LiveRobot) -> None:
    assert robot.drive.straight(0.5).x == pytest.approx(0.5, abs=0.005)
    assert robot.drive.turn(math.pi / 2).heading == pytest.approx(math.pi / 2, abs=0.005)
    assert robot.range.read().time == robot.camera.read().time == robot.clock.now()


def test_drive_goes_to_places(robot: LiveRobot) -> None:
    assert robot.drive.go_to(0.3, 0.1)[:2] == pytest.approx((0.3, 0.1), abs=0.005)
    assert robot.drive.follow_path([(0.5, 0.2), (0.4, 0.4)])[:2] == pytest.approx((0.4, 0.4), abs=0.005)
    assert robot.drive.face(1.0).heading == pytest.approx(1.0, abs=0.005)


def test_simulation_stands_still_between_two_calls(robot: LiveRobot) -> None:
    robot.wait(1.0)
    assert robot.clock.now() == 1.0
    robot.wait(0.5)
    assert robot.clock.now() == 1.5


@pytest.mark.slow
def test_long_pause_after_the_first_manoeuvre_is_no_tick(robot: LiveRobot) -> None:
    robot.drive.straight(0.0)
    robot.wait(10.0)
    assert robot.drive.straight(0.5).x == pytest.approx(0.5, abs=0.005)


def test_wheels_stand_after_a_routine_that_leaves_a_velocity(robot: LiveRobot) -> None:
    def drive_on(robot: Robot) -> Routine[str]:
        for _ in range(10):
            robot.drive.set_velocity(0.3, 0.0)
            yield
        return "done"

    assert robot.run(drive_on(robot)) == "done"
    before = robot.drive.pose
    robot.wait(0.05)  # the motors' lag
    robot.wait(1.0)
    assert robot.drive.pose.x - before.x < 0.03
    assert robot.ground_truth
    assert robot.ground_truth.is_at_rest


def test_move_drives_for_a_time(robot: LiveRobot) -> None:
    robot.drive.move(0.2, seconds=1.0)
    robot.wait(0.5)
    assert robot.drive.pose.x == pytest.approx(0.2, abs=0.02)


class Spin(Behaviour):
    needs = frozenset({Role.DRIVE})

    def step(self, robot: Robot) -> Status:
        robot.drive.set_velocity(0.0, 1.0)
        return Status.SUCCESS if robot.clock.now() > 0.5 else Status.RUNNING


def test_app_runs_in_a_session(robot: LiveRobot) -> None:
    assert robot.run(Spin()) is Status.SUCCESS
    assert robot.drive.pose.heading > 0.3


def test_map_shows_what_the_range_sensor_has_seen() -> None:
    with robotcore.open("rover", world="arena") as robot:
        assert robot.map
        before = int(robot.map.free.sum())
        robot.drive.turn(1.0)
        assert int(robot.map.free.sum()) > before
        assert robot.map.occupied.any()


def test_picture_of_the_robot_can_be_saved(robot: LiveRobot, tmp_path: Path) -> None:
    robot.drive.straight(0.2)
    robot.show().save(tmp_path / "robot.png")
    assert (tmp_path / "robot.png").read_bytes().startswith(b"\x89PNG")


def test_all_devices_are_open_and_needs_open_some() -> None:
    with robotcore.open("rover") as robot:
        assert {"nose", "eye", "left_motor", "left_encoder"} <= set(robot.devices)
    with robotcore.open("rover", needs={Role.RANGE}) as robot:
        assert not robot.has(Role.DRIVE)
        assert not robot.all(Camera)


@pytest.mark.slow
def test_two_sessions_at_once() -> None:
    with robotcore.open(world="open") as first, robotcore.open(world="open") as second:
        first.drive.straight(0.2)
        second.drive.straight(-0.1)
        assert first.drive.pose.x > 0.19
        assert second.drive.pose.x < -0.09


@pytest.mark.slow
def test_next_open_closes_a_robot_that_the_program_has_lost() -> None:
    def open_and_lose() -> RunSession:
        robot = robotcore.open(world="open")
        robot.drive.straight(0.1)
        with pytest.raises(BlockedError):
            robotcore.open(world="arena").drive.straight(1.0)
        return robot._session

    lost = open_and_lose()
    assert lost.result is None
    with robotcore.open(world="open"):
        assert lost.result
        assert lost.result.outcome is Outcome.SUCCESS


@pytest.mark.slow
def test_next_open_leaves_a_robot_that_another_name_has() -> None:
    robot = robotcore.open(world="open")
    first = robot
    robot = robotcore.open(world="open")
    first.drive.straight(0.1)
    first.close()
    robot.close()


def test_same_calls_give_the_same_trace() -> None:
    def play() -> str:
        with robotcore.open(world="arena", seed=7, faults="range noise=0.05") as robot:
            robot.drive.turn(0.5)
            robot.wait(0.3)
        assert robot.result
        return str(robot.result.trace_sha256)

    assert play() == play()


def interrupt(after_s: float, number: int = signal.SIGINT) -> None:
    threading.Timer(after_s, os.kill, (os.getpid(), number)).start()


@pytest.mark.slow
def test_ctrl_c_ends_the_call_and_the_robot_stays_open() -> None:
    with robotcore.open(world="open", realtime=True) as robot:
        interrupt(0.3)
        with pytest.raises(KeyboardInterrupt):
            robot.drive.straight(5.0)
        stopped = robot.drive.pose.x
        robot.wait(0.3)
        assert robot.drive.pose.x - stopped < 0.03
        robot.drive.straight(0.1)
    assert robot.result
    assert robot.result.outcome is Outcome.SUCCESS
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.slow
def test_a_call_follows_the_pace_that_another_thread_sets() -> None:
    with robotcore.open(world="open") as robot:
        robot.pace.pause()
        threading.Timer(0.2, robot.pace.resume).start()
        wall = MonotonicClock()
        robot.wait(1.0)
        assert wall.now() >= 0.15
        robot.pace.speed = 5.0
        wall = MonotonicClock()
        robot.wait(1.0)
        assert wall.now() >= 0.19
    assert robot.result
    assert robot.result.overruns == 0


def test_ctrl_c_ends_a_call_that_is_paused_and_a_sensor_can_be_read_in_a_pause() -> None:
    with robotcore.open(world="open") as robot:
        robot.pace.pause()
        robot.range.read()
        interrupt(0.2)
        with pytest.raises(KeyboardInterrupt):
            robot.drive.straight(0.1)
        robot.pace.resume()
        robot.drive.straight(0.1)


def test_a_robot_whose_time_passes_by_itself_has_no_pace(raises: Raises, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SteppedClock, "is_lockstep", False)
    with robotcore.open(world="open") as robot, raises(UsageError, "no-pace"):
        robot.pace.pause()


def test_other_signal_closes_the_robot() -> None:
    received: list[int] = []
    before = signal.signal(signal.SIGTERM, lambda number, _: received.append(number))
    try:
        with robotcore.open(world="open", realtime=True) as robot:
            interrupt(0.2, signal.SIGTERM)
            with pytest.raises(robotcore.errors.Interrupted):
                robot.drive.straight(5.0)
            assert robot.result
            assert robot.result.outcome is Outcome.INTERRUPTED
    finally:
        signal.signal(signal.SIGTERM, before)
    assert received == [signal.SIGTERM]


def test_exception_of_a_routine_reaches_the_caller(robot: LiveRobot) -> None:
    def fail(robot: Robot) -> Routine[None]:
        robot.drive.set_velocity(0.3, 0.0)
        yield
        raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        robot.run(fail(robot))
    robot.wait(0.1)
    assert robot.ground_truth
    assert robot.ground_truth.is_at_rest


def fail_because_of_a_key(robot: Robot) -> Routine[None]:
    yield
    try:
        {"cube": 1}["ball"]
    except KeyError as error:
        raise ValueError("broken") from error


def list_functions(error: BaseException) -> list[str]:
    return [frame.name for frame in extract_tb(error.__traceback__)][1:]


def test_traceback_of_a_routine_begins_in_the_routine(robot: LiveRobot) -> None:
    with pytest.raises(ValueError, match="broken") as caught:
        robot.run(fail_because_of_a_key(robot))
    assert list_functions(caught.value) == ["run", "fail_because_of_a_key"]
    assert isinstance(caught.value.__cause__, KeyError)


@pytest.mark.slow
def test_traceback_of_an_error_of_robotcore_ends_at_the_call(robot: LiveRobot) -> None:
    with pytest.raises(BlockedError) as blocked, robotcore.open(world="arena") as other:
        other.drive.straight(3.0)
    assert list_functions(blocked.value) == ["straight", "run"]
    with pytest.raises(UnknownNameError) as unknown:
        robotcore.open(world="nowhere")
    assert list_functions(unknown.value) == ["open"]


def test_lost_sensor_is_an_error_and_the_robot_stays_open() -> None:
    with robotcore.open(world="open", faults="range lost=0.5 after=1") as robot:
        with pytest.raises(DeviceError, match="nose"):
            robot.drive.straight(2.0)
        robot.run(wait_without_range(robot, 0.6))
        robot.drive.turn(0.2)


def wait_without_range(robot: Robot, seconds: float) -> Routine[None]:
    return robotcore.wait(robot, seconds)


def test_error_of_the_safety_stage_ends_the_session(raises: Raises) -> None:
    def command_nan(robot: Robot) -> Routine[None]:
        robot.drive.set_velocity(math.nan, 0.0)
        yield

    with robotcore.open(world="open") as robot:
        with pytest.raises(InvalidCommandError):
            robot.run(command_nan(robot))
        line = command_nan.__code__.co_firstlineno + 1
        with raises(UsageError, "robot-stopped", hide=[f".py:{line}"]):
            robot.drive.straight(0.1)
        assert repr(robot) == "<Robot rover: stopped by an error>"
    assert robot.result
    assert robot.result.outcome is Outcome.STOPPED


def test_closed_robot_is_refused(raises: Raises) -> None:
    with robotcore.open(world="open") as robot:
        pass
    robot.close()
    with raises(DeviceClosedError, "device-closed"):
        robot.wait(1.0)
    with raises(DeviceClosedError, "device-closed"):
        robot.range.read()
    assert repr(robot) == "<Robot rover: closed>"


class Empty(Behaviour):
    """An app without a method."""


BAD: dict[str, tuple[Callable[[Any], Any], type[Exception], str]] = {
    "velocity": (lambda robot: robot.drive.set_velocity(0.1, 0.0), UsageError, "velocity-without-time"),
    "wheels": (lambda robot: robot.drive.set_wheels(1.0, 1.0), UsageError, "velocity-without-time"),
    "number": (lambda robot: robot.run(3), UsageError, "not-a-routine"),
    "class": (lambda robot: robot.run(Spin), UsageError, "not-an-instance"),
    "empty": (lambda robot: robot.run(Empty()), BehaviourError, "method-missing"),
    "nested": (lambda robot: robot.wait_until(lambda: robot.drive.turn(1.0)), UsageError, "call-in-routine"),
    "close": (lambda robot: robot.wait_until(robot.close), UsageError, "closed-in-routine"),
    "timeout": (lambda robot: robot.wait_until(lambda: False, timeout_s=0.2), RoutineTimeoutError, "routine-timeout"),
    "device": (lambda robot: robot["gripper"], UnknownNameError, "unknown-device"),
    "infinite": (lambda robot: robot.wait(math.inf), UsageError, "wrong-time"),
    "absurd": (lambda robot: robot.drive.straight(1e9), UsageError, "manoeuvre-argument"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_call_is_refused_and_the_robot_stays_open(robot: LiveRobot, raises: Raises, case: str) -> None:
    call, error, kind = BAD[case]
    with raises(error, kind):
        call(robot)
    robot.wait(0.1)


def test_call_of_another_thread_is_refused(robot: LiveRobot, raises: Raises) -> None:
    failures: list[Exception] = []

    def call() -> None:
        try:
            robot.wait(0.1)
        except UsageError as error:
            failures.append(error)

    thread = threading.Thread(target=call)
    thread.start()
    thread.join()
    with raises(UsageError, "wrong-thread"):
        raise failures[0]


OPEN: dict[str, tuple[dict[str, Any], type[Exception], str]] = {
    "world": ({"world": "nowhere"}, UnknownNameError, "unknown-world"),
    "robot": ({"robot": "nothing"}, UnknownNameError, "unknown-robot"),
    "backend": ({"backend": "kinematics"}, UnknownNameError, "unknown-backend"),
    "fault": ({"faults": "range melt"}, UsageError, "unknown-effect"),
    "needs": ({"needs": {"gripper"}}, UnmetNeedError, "unmet-need"),
    "needs text": ({"needs": "nose"}, UsageError, "needs-not-a-set"),
    "rate": ({"rate_hz": math.nan}, UsageError, "rate-out-of-range"),
    "option": ({"options": {"colour": "red"}}, UnknownNameError, "unknown-option"),
    "record": ({"record": "session.txt"}, RecordingError, "file-ending"),
    "record last": ({"record_last_s": 600}, UsageError, "record-last"),
    "record last 0": ({"record": "session.mcap", "record_last_s": 0}, UsageError, "record-last"),
    "record last nan": ({"record": "session.mcap", "record_last_s": math.nan}, UsageError, "record-last"),
    "seed": ({"seed": "seven"}, UsageError, "wrong-type"),
    "no drive": ({"robot": "lookout", "needs": {Role.DRIVE}}, UnmetNeedError, "unmet-need"),
    "no seed": ({"randomise": True}, UsageError, "seed-missing"),
    "no recording": ({"backend": "replay"}, UsageError, "no-recording"),
}


@pytest.mark.parametrize("case", OPEN)
def test_robot_that_cannot_be_opened_is_an_error(raises: Raises, case: str) -> None:
    asked, error, kind = OPEN[case]
    with raises(error, kind):
        robotcore.open(**asked)


def test_tick_of_a_paused_loop_is_renewed_in_real_time() -> None:
    """A clock whose source goes on, as on a real robot, shows the present time for a read. No tick begins."""
    from robotcore.hal.clock import TickClock

    source = SteppedClock(20, lambda steps: None)
    clock = TickClock(source)
    source.sleep_until(1.0)
    clock.renew()
    assert clock.now() == 0.0
    clock.renewal_age = 0.05
    clock.renew()
    assert (clock.now(), clock.tick, clock.reading) == (1.0, 0, 1)


def test_error_of_a_file_has_one_traceback(tmp_path: Path) -> None:
    def fail(robot: LiveRobot, call: str) -> BaseException:
        with pytest.raises(ValueError, match=r"there is no folder|No such file") as caught:
            robot.show().save(tmp_path / "no/robot.png") if call == "picture" else read(tmp_path / "no.mcap")
        return caught.value

    with robotcore.open(world="open") as robot:
        for call in ("picture", "recording"):
            assert "".join(format_exception(fail(robot, call))).count("Traceback") == 1
