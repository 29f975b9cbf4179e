"""Apps that define ``run``: a generator whose ``yield`` ends a tick."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from robotcore import Behaviour, Outcome, Robot, Role, RunRequest, RunResult, Status, run
from robotcore.autonomy.routines import Routine, on_stop, race, wait, with_timeout
from robotcore.errors import BehaviourError, RobotcoreError, WatchdogError
from robotcore.testing import MockRobot
from tests.robotcore.runtime.test_device_loss import patient as patient  # noqa: PLC0414  a fixture
from tests.texts import CheckText, Raises


class Nod(Behaviour):
    """Turns to the left and to the right."""

    needs = frozenset({Role.DRIVE})
    milestones = ("left", "right")

    def run(self, robot: Robot) -> Routine[Status]:
        self.state = "left"
        yield from race(turn_on(robot, 0.5), wait(robot, 0.2))
        self.state = "right"
        yield from race(turn_on(robot, -0.5), wait(robot, 0.1))
        return Status.SUCCESS


def turn_on(robot: Robot, angular: float) -> Routine[None]:
    while True:
        robot.drive.set_velocity(0.0, angular)
        yield


class SteppedNod(Behaviour):
    """Does the same in steps."""

    needs = frozenset({Role.DRIVE})

    def step(self, robot: Robot) -> Status:
        now = robot.clock.now() + 1e-9
        self.state = "left" if now < 0.2 else "right"
        if now < 0.2:
            robot.drive.set_velocity(0.0, 0.5)
        elif now < 0.3:
            robot.drive.set_velocity(0.0, -0.5)
        return Status.SUCCESS if now >= 0.3 else Status.RUNNING


class Twice(Behaviour):
    needs = frozenset({Role.DRIVE})

    def __init__(self, build: Callable[[], Behaviour]) -> None:
        self._build = build

    def run(self, robot: Robot) -> Routine[Status]:
        yield from self._build().run(robot)
        return (yield from self._build().run(robot))


def test_states_and_milestones_of_a_routine_are_recorded() -> None:
    result = run(RunRequest(Nod))
    assert (result.outcome, result.ticks, result.milestones) == (Outcome.SUCCESS, 7, {"left": 0.0, "right": 0.2})


def test_routine_sends_the_commands_of_the_same_steps() -> None:
    routine, stepped = MockRobot(), MockRobot()
    assert routine.run(Nod(), 20) is stepped.run(SteppedNod(), 20) is Status.SUCCESS
    assert routine.wheels == stepped.wheels


@pytest.mark.parametrize("app", [Nod, SteppedNod])
def test_app_runs_within_another(app: type[Behaviour]) -> None:
    robot = MockRobot()
    assert robot.run(Twice(app), 50) is Status.SUCCESS
    assert len(robot.ticks) == (13 if app is Nod else 7)


def test_app_can_run_again() -> None:
    app = Nod()
    assert [MockRobot().run(app, 20) for _ in range(2)] == [Status.SUCCESS] * 2


class Both(Nod):
    def step(self, robot: Robot) -> Status:
        return Status.SUCCESS


class Neither(Behaviour):
    pass


def app_of(function: Callable[..., Any]) -> type[Behaviour]:
    return type("App", (Behaviour,), {"run": function, "needs": frozenset({Role.DRIVE})})


def yield_number(self: Behaviour, robot: Robot) -> Any:
    yield 3


def yield_routine(self: Behaviour, robot: Robot) -> Any:
    yield wait(robot, 1.0)


def yield_status(self: Behaviour, robot: Robot) -> Any:
    yield Status.RUNNING


def return_nothing(self: Behaviour, robot: Robot) -> Any:
    yield


def return_running(self: Behaviour, robot: Robot) -> Any:
    yield
    return Status.RUNNING


def do_nothing(self: Behaviour, robot: Robot) -> Any:
    return Status.SUCCESS


def forget_yield_from(self: Behaviour, robot: Robot) -> Any:
    wait(robot, 0.1)
    return Status.SUCCESS


def take_nothing(self: Behaviour) -> Any:
    yield


def divide(self: Behaviour, robot: Robot) -> Any:
    yield
    return 1 / 0


BAD = {
    "both": (Both, "step-and-run"),
    "neither": (Neither, "method-missing"),
    "number": (app_of(yield_number), "behaviour"),
    "routine": (app_of(yield_routine), "behaviour"),
    "status": (app_of(yield_status), "behaviour"),
    "none": (app_of(return_nothing), "not-a-status"),
    "running": (app_of(return_running), "not-a-status"),
    "no generator": (app_of(do_nothing), "not-a-generator"),
    "no yield from": (app_of(forget_yield_from), "not-a-generator"),
    "no parameter": (app_of(take_nothing), "wrong-parameters"),
    "exception": (app_of(divide), "behaviour"),
    "hidden": (type("App", (Nod,), {"run": 3}), "method-hidden"),
}


@pytest.mark.filterwarnings("ignore:the routine wait was never run")
@pytest.mark.parametrize("case", BAD)
def test_mistake_in_an_app_is_named(raises: Raises, case: str) -> None:
    app, kind = BAD[case]
    with raises(BehaviourError, kind):
        MockRobot().run(app(), 3)


@pytest.mark.slow
def test_loop_without_a_yield_is_stopped(check_text: CheckText) -> None:
    def spin(self: Behaviour, robot: Robot) -> Any:
        yield
        while True:
            pass

    result = run(RunRequest(app_of(spin)), timeout_scale=0.2)
    assert isinstance(result.error, WatchdogError)
    check_text(result.reason, hide=[f".py:{spin.__code__.co_firstlineno + 2}"])


class Cleaning(Behaviour):
    """Counts its clean-ups."""

    needs = frozenset({Role.DRIVE, Role.RANGE})

    def __init__(self, act: Callable[[Robot], Routine[Any]], clean_up: Callable[[], object] = lambda: None) -> None:
        self._act, self._clean_up, self.clean_ups = act, clean_up, 0

    def run(self, robot: Robot) -> Routine[Status]:
        yield from on_stop(self._act(robot), self._clean)
        return Status.SUCCESS

    def _clean(self) -> None:
        self.clean_ups += 1
        self._clean_up()


def drive_on(robot: Robot) -> Routine[None]:
    robot.drive.set_velocity(0.2, 0.0)
    return wait(robot, 60.0)


def keep_driving(robot: Robot) -> Routine[None]:
    while True:
        robot.drive.set_velocity(0.2, 0.0)
        yield


def fail(robot: Robot) -> Routine[None]:
    yield
    raise ValueError("broken")


def command_nan(robot: Robot) -> Routine[None]:
    yield
    robot.drive.set_velocity(float("nan"), 0.0)


def read_range(robot: Robot) -> Routine[None]:
    while robot.clock.now() < 2.5:
        robot.range.read()
        yield


@pytest.mark.parametrize(
    "act, faults, outcome",
    [
        (drive_on, (), Outcome.TIMEOUT),
        (fail, (), Outcome.ERROR),
        (command_nan, (), Outcome.STOPPED),
        (read_range, ("range lost=9 after=0.2",), Outcome.ERROR),
        (lambda robot: wait(robot, 0.1), (), Outcome.SUCCESS),
        (lambda robot: with_timeout(robot, 0.1, drive_on(robot)), (), Outcome.FAILURE),
    ],
    ids=["timeout", "exception", "safety", "device", "success", "routine"],
)
def test_clean_up_runs_on_each_way_out(
    act: Callable[[Robot], Routine[Any]], faults: tuple[str, ...], outcome: Outcome
) -> None:
    app = Cleaning(act)
    assert run(RunRequest(app, timeout_s=0.5, faults=faults)).outcome is outcome
    assert app.clean_ups == 1


def divide_by_zero() -> float:
    return 1 / 0


def test_failed_clean_up_ends_the_run(raises: Raises) -> None:
    with raises(BehaviourError, "behaviour"):
        raise_error(run(RunRequest(Cleaning(drive_on, divide_by_zero), timeout_s=0.5)))


def test_lost_device_hides_no_failed_clean_up(check_text: CheckText) -> None:
    result = run(RunRequest(Cleaning(keep_driving, divide_by_zero), faults=("drive lost=9 after=0.2",)))
    assert result.exit_status == 3
    check_text("\n".join([result.reason, *result.notes]))


def raise_error(result: RunResult) -> None:
    assert isinstance(result.error, RobotcoreError)
    raise result.error


@pytest.mark.parametrize("target", ["range", "drive", "encoders", "connection"])
def test_routine_continues_when_a_lost_device_is_back(patient: str, target: str) -> None:
    app = Cleaning(read_and_drive)
    result = run(RunRequest(app, robot=patient, timeout_s=4.0, faults=(f"{target} lost=0.5 after=1",)))
    assert (result.outcome, app.clean_ups) == (Outcome.SUCCESS, 1)


def read_and_drive(robot: Robot) -> Routine[None]:
    while robot.clock.now() < 2.5:
        robot.range.read()
        assert abs(robot.drive.pose.heading) < 9
        robot.drive.set_velocity(0.0, 0.5)
        yield


def test_device_that_is_lost_for_too_long_ends_the_routine(patient: str) -> None:
    app = Cleaning(read_range)
    result = run(RunRequest(app, robot=patient, timeout_s=4.0, faults=("range lost=3 after=1",)))
    assert (result.exit_status, result.sim_time_s) == (3, 2.0)
    assert app.clean_ups == 1


def look_and_wait(robot: Robot) -> Routine[None]:
    """Read the camera in the first half second."""
    while robot.clock.now() < 0.5:
        robot.camera.read()
        yield
    yield from wait(robot, 1.5)


@pytest.mark.parametrize("after, lost", [(0.2, True), (1.0, False)])
def test_routine_waits_only_for_devices_that_it_has_read_in_its_last_tick(
    patient: str, after: float, *, lost: bool
) -> None:
    app = Cleaning(look_and_wait)
    app.needs = app.needs | {Role.CAMERA}  # type: ignore[misc]  # of this app only
    result = run(RunRequest(app, robot=patient, timeout_s=4.0, faults=(f"camera lost=0.5 after={after}",)))
    assert result.outcome is Outcome.SUCCESS
    assert len(result.notes) == lost
