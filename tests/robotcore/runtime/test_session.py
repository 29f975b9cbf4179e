from __future__ import annotations

import json
import math
import signal
from contextlib import suppress

import pytest

from robotcore.errors import (
    BackendError,
    BehaviourError,
    DeviceError,
    Interrupted,
    InvalidCommandError,
    StaleSampleError,
)
from robotcore.hal.clock import SteppedClock
from robotcore.hal.robot import Robot, Role
from robotcore.runtime.behaviour import Status
from robotcore.runtime.result import Outcome
from robotcore.runtime.session import RunContext, RunRequest, RunResult
from tests.robotcore.fakes import FunctionApp, RigBackend
from tests.robotcore.runs import Runner, Watcher, drive_then, drive_then_raise, drive_wheels
from tests.texts import CheckText


@pytest.mark.parametrize(
    "status, outcome, exit_status",
    [(Status.SUCCESS, Outcome.SUCCESS, 0), (Status.FAILURE, Outcome.FAILURE, 1)],
)
def test_status_of_the_app_is_the_outcome_and_json_has_every_field_but_the_error(
    perform: Runner, backend: RigBackend, status: Status, outcome: Outcome, exit_status: int
) -> None:
    result = perform(drive_then(lambda _: status))
    assert (result.outcome, result.exit_status, result.ticks) == (outcome, exit_status, 3)
    assert result.error is None
    assert backend.rig.wheels == (0.0, 0.0)
    fields = json.loads(result.to_json())
    assert fields["outcome"] == status.value
    assert set(fields) == set(RunResult.__dataclass_fields__) - {"error"}


def test_timeout_is_a_failure_with_the_apps_state(perform: Runner, check_text: CheckText) -> None:
    result = perform(drive_then(lambda _: None), RunRequest("app", timeout_s=0.5))
    assert (result.outcome, result.exit_status) == (Outcome.TIMEOUT, 1)
    check_text(result.reason)
    assert (result.sim_time_s, result.ticks) == (0.5, 11)


@pytest.mark.parametrize(
    "error, outcome, exit_status",
    [
        (BackendError("the simulator has gone"), Outcome.ERROR, 3),
        (DeviceError("eye", "no picture"), Outcome.ERROR, 3),
        (InvalidCommandError("nan"), Outcome.STOPPED, 4),
        (StaleSampleError("nose", 2.0, 1.0), Outcome.STOPPED, 4),
        (BehaviourError("lost"), Outcome.ERROR, 5),
        (Interrupted(signal.SIGINT), Outcome.INTERRUPTED, 130),
        (Interrupted(signal.SIGTERM), Outcome.INTERRUPTED, 143),
    ],
    ids=lambda value: type(value).__name__,
)
def test_error_has_an_outcome_and_stops_every_motor(
    perform: Runner, backend: RigBackend, error: BaseException, outcome: Outcome, exit_status: int
) -> None:
    result = perform(drive_then_raise(error))
    assert (result.outcome, result.exit_status) == (outcome, exit_status)
    assert result.error is error
    assert result.reason == str(error)
    assert backend.rig.wheels == (0.0, 0.0)
    assert (backend.rig.left.releases, backend.rig.right.releases) == (1, 1)


def test_velocity_that_is_nan_ends_the_run_even_if_the_app_catches_the_error(perform: Runner) -> None:
    def swallow(robot: Robot) -> Status:
        with suppress(Exception):
            drive_wheels(robot, float("nan"))
        return Status.RUNNING

    result = perform(drive_then(swallow))
    assert (result.outcome, result.exit_status) == (Outcome.STOPPED, 4)


@pytest.mark.parametrize(
    "needs, wants, opened",
    [
        ({Role.CAMERA}, (), {"eye"}),
        ({Role.RANGE}, {Role.DISPLAY}, {"nose", "screen"}),
        ({Role.DRIVE}, (), {"left_motor", "right_motor", "left_encoder", "right_encoder", "nose"}),
    ],
)
def test_only_needed_and_wanted_devices_are_opened(
    perform: Runner, backend: RigBackend, needs: set[Role], wants: set[Role], opened: set[str]
) -> None:
    app = FunctionApp(lambda _: Status.SUCCESS)
    app.needs, app.wants = frozenset(needs), frozenset(wants)  # type: ignore[misc]
    perform(app)
    assert backend.rig.names == opened


@pytest.mark.parametrize("realtime, speed", [(False, math.inf), (True, 1.0)])
def test_simulated_time_is_paced_only_on_request(perform: Runner, *, realtime: bool, speed: float) -> None:
    watcher = Watcher()
    perform(drive_then(lambda _: Status.SUCCESS), RunRequest("app", realtime=realtime), observers=[watcher])
    run: RunContext = watcher.calls[0][1]
    assert run.pace
    assert run.pace.speed == speed


def test_a_robot_whose_time_passes_by_itself_has_no_pace(perform: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SteppedClock, "is_lockstep", False)
    watcher = Watcher()
    perform(drive_then(lambda _: Status.SUCCESS), observers=[watcher])
    run: RunContext = watcher.calls[0][1]
    assert run.pace is None


def test_an_observer_and_the_result_have_the_statistics_of_the_ticks(perform: Runner) -> None:
    watcher = Watcher()
    result = perform(drive_then(lambda _: Status.SUCCESS), observers=[watcher])
    run: RunContext = watcher.calls[0][1]
    assert list(result.tick_times_us) == ["read", "decide", "guard", "commit", "record", "sleep"]
    assert result.tick_times_us == run.statistics.summarise()
    assert result.tick_times_us["decide"]["worst"] > 0.0


def test_timeout_of_a_robot_that_stands_before_an_obstacle_names_the_sensor(
    perform: Runner, backend: RigBackend, check_text: CheckText
) -> None:
    backend._prepare = lambda rig: setattr(rig.nose, "distance", 0.05)
    check_text(perform(drive_then(lambda _: None), RunRequest("app", timeout_s=0.5)).reason)


def test_observers_get_the_run_each_tick_and_the_result(perform: Runner) -> None:
    watcher = Watcher()
    result = perform(drive_then(lambda _: Status.SUCCESS), observers=[watcher])
    assert [name for name, _ in watcher.calls] == ["begin", "tick", "tick", "tick", "end"]
    assert watcher.calls[-1][1] is result
    assert [record.tick for name, record in watcher.calls if name == "tick"] == [0, 1, 2]


def test_result_has_milestones_interventions_and_digest(perform: Runner, backend: RigBackend) -> None:
    app = drive_then(lambda _: Status.SUCCESS)
    app.milestones = ("start", "never")  # type: ignore[misc]
    backend._prepare = lambda rig: setattr(rig.nose, "distance", 0.05)
    first, second = perform(app), perform(drive_then(lambda _: Status.SUCCESS))
    assert (first.milestones, first.interventions) == ({"start": 0.0}, 3)
    assert first.intervention_s == {"range guard": 0.1}
    assert first.trace_sha256 == second.trace_sha256
