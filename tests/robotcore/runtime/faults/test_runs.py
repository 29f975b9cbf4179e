"""Runs with faults. Each run ends with the expected outcome and stopped wheels. Equal runs have equal traces."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest

from robotcore import Outcome, RunRequest, RunResult
from robotcore.errors import DeviceError
from robotcore.hal.robot import Robot
from robotcore.plugins import fault_names
from robotcore.runtime.behaviour import Status
from robotcore.runtime.faults.planning import load_fault
from robotcore.runtime.session import run
from tests.robotcore.fakes import FunctionApp
from tests.robotcore.runtime.faults.conftest import Wheels

SPECS = {
    "eye drop=0.5": Outcome.TIMEOUT,
    "camera freeze after=1 lasts=0.5": Outcome.TIMEOUT,
    "camera freeze after=1": Outcome.STOPPED,
    "camera delay=0.2": Outcome.TIMEOUT,
    "camera delay=2 after=0.5": Outcome.STOPPED,
    "camera noise=20": Outcome.TIMEOUT,
    "range noise=0.1": Outcome.TIMEOUT,
    "range stuck=1.5": Outcome.TIMEOUT,
    "range no_echo=0.5": Outcome.TIMEOUT,
    "range no_echo=1": Outcome.STOPPED,
    "range spikes=0.2": Outcome.TIMEOUT,
    "left_motor dead after=1": Outcome.TIMEOUT,
    "right_motor weak=0.5": Outcome.TIMEOUT,
    "drive reversed after=1 lasts=0.5": Outcome.TIMEOUT,
    "encoders slip=0.3": Outcome.TIMEOUT,
    "encoders drop=1": Outcome.STOPPED,
    "range bias=0.05": Outcome.TIMEOUT,
    "encoders noise=0.01": Outcome.TIMEOUT,
    "left_encoder bias=0.2": Outcome.TIMEOUT,
    "right_encoder spikes=0.05 size=0.5": Outcome.TIMEOUT,
    "loop stall=0.4 every=1": Outcome.TIMEOUT,
    "connection lost=1 after=1": Outcome.ERROR,
}
"""The outcome of green-search for each fault, with a time limit of three seconds."""

REASONS = {
    Outcome.TIMEOUT: "not done after 3 s",
    Outcome.STOPPED: "the newest sample is ",
    Outcome.ERROR: "is disconnected by the fault",
}


def search(*faults: str, backend: str = "kinematic", timeout_s: float = 3.0) -> RunResult:
    return run(RunRequest("green-search", backend, seed=7, timeout_s=timeout_s, faults=faults))


@pytest.mark.slow
@pytest.mark.parametrize("spec", SPECS)
def test_run_ends_with_the_expected_outcome_stopped_wheels_and_an_equal_trace(wheels: Wheels, spec: str) -> None:
    result = search(spec)
    assert result.outcome is SPECS[spec]
    assert REASONS[result.outcome] in result.reason
    assert result.faults == [spec]
    assert wheels == {"left_motor": 0.0, "right_motor": 0.0}
    assert search(spec).trace_sha256 == result.trace_sha256


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "pybullet"])
@pytest.mark.parametrize("effect", ["dead", "reversed", "weak=0.1"])
def test_wheel_that_does_not_follow_stops_the_run_and_names_its_motor(
    wheels: Wheels, backend: str, effect: str
) -> None:
    if backend == "pybullet":
        pytest.importorskip("pybullet")
    result = search(f"left_motor {effect} after=1", backend=backend, timeout_s=30.0)
    assert (result.outcome, result.exit_status) == (Outcome.STOPPED, 4)
    assert result.reason.startswith("left_motor was commanded to turn ")
    assert "right_motor" not in result.reason
    assert set(wheels.values()) <= {0.0}


def test_specs_contain_every_fault() -> None:
    names = {spec.split()[1].partition("=")[0] for spec in SPECS}
    assert names == {name.partition(".")[0] for name in fault_names()}


@pytest.mark.slow
def test_fault_that_does_not_begin_leaves_the_trace_unchanged() -> None:
    examples = [re.sub(r" after=\S+", "", load_fault(name).example) for name in fault_names()]
    later = [f"{example} after=1000" for example in examples]
    assert search(*later).trace_sha256 == search().trace_sha256


def drive_and_wait(on_loss: Callable[[Robot], object], *faults: str) -> RunResult:
    """Run an app that drives 0.3 m, and calls ``on_loss`` while a device is lost."""

    def step(robot: Robot) -> Status:
        try:
            is_there = robot.drive.pose.x > 0.3
            robot.drive.set_velocity(0.2, 0.0)
        except DeviceError:
            on_loss(robot)
            return Status.RUNNING
        return Status.SUCCESS if is_there else Status.RUNNING

    return run(RunRequest(FunctionApp(step), world="open", timeout_s=5.0, faults=faults))


def test_app_that_stops_its_wheels_continues_after_a_lost_connection(wheels: Wheels) -> None:
    plain = drive_and_wait(lambda robot: robot.drive.stop())
    result = drive_and_wait(lambda robot: robot.drive.stop(), "connection lost=1 after=0.5")
    assert (result.outcome, result.reason) == (Outcome.SUCCESS, "")
    assert plain.sim_time_s + 0.9 < result.sim_time_s < plain.sim_time_s + 1.3
    assert wheels == {"left_motor": 0.0, "right_motor": 0.0}


def stop_and_drive(robot: Robot) -> None:
    robot.drive.stop()
    robot.drive.set_wheels(1.0, 1.0)


@pytest.mark.parametrize("instead", [lambda _: None, stop_and_drive], ids=["nothing", "stop and drive"])
def test_lost_connection_ends_the_run_unless_the_app_stops_every_wheel(
    wheels: Wheels, instead: Callable[[Robot], object]
) -> None:
    result = drive_and_wait(instead, "connection lost=1 after=0.5")
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert result.reason.endswith('is disconnected by the fault "connection lost=1 after=0.5"')
    assert wheels == {"left_motor": 0.0, "right_motor": 0.0}
