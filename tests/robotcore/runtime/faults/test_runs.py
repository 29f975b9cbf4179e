"""Whole runs of the apps in which something fails: each ends by its name, with its wheels at rest, and repeatably."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotcore import Outcome, RunRequest, RunResult
from robotcore.plugins import fault_names
from robotcore.runtime.faults.planning import load_fault
from robotcore.runtime.session import run

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
    "loop stall=0.4 every=1": Outcome.TIMEOUT,
    "connection lost=1 after=1": Outcome.ERROR,
}
"""How green-search ends where it is given three seconds."""

REASONS = {
    Outcome.TIMEOUT: "not done after 3 s",
    Outcome.STOPPED: "the newest sample is ",
    Outcome.ERROR: "the connection is lost",
}

Wheels = dict[str, float]


@pytest.fixture
def wheels(monkeypatch: pytest.MonkeyPatch) -> Wheels:
    """Return the last command of each motor of the built-in simulator."""
    from drivers.kinematic.devices import KinematicMotor

    commands: Wheels = {}
    apply = KinematicMotor._apply

    def noting(motor: KinematicMotor, rad_s: float) -> None:
        commands[motor.name] = rad_s
        apply(motor, rad_s)

    monkeypatch.setattr(KinematicMotor, "_apply", noting)
    return commands


def search(*faults: str, backend: str = "kinematic", timeout_s: float = 3.0) -> RunResult:
    return run(RunRequest("green-search", backend, seed=7, timeout_s=timeout_s, faults=faults))


def in_bullet(*faults: str) -> RunResult:
    pytest.importorskip("pybullet")
    return search(*faults, backend="pybullet", timeout_s=1.5)


@pytest.mark.parametrize("spec", SPECS)
def test_a_run_ends_as_it_must_with_its_wheels_at_rest_and_the_same_twice(wheels: Wheels, spec: str) -> None:
    result = search(spec)
    assert result.outcome is SPECS[spec]
    assert REASONS[result.outcome] in result.reason
    assert result.faults == [spec]
    assert wheels == {"left_motor": 0.0, "right_motor": 0.0}
    assert search(spec).trace_sha256 == result.trace_sha256


@pytest.mark.parametrize("spec", ["camera freeze after=0.2", "connection lost=1 after=1"])
def test_in_bullet_a_run_ends_as_it_does_in_the_built_in_simulator(spec: str) -> None:
    result = in_bullet(spec)
    assert (result.outcome, result.reason) == (search(spec).outcome, search(spec).reason)
    assert in_bullet(spec).trace_sha256 == result.trace_sha256


@pytest.mark.parametrize("spec", ["drive dead", "left_motor weak=0.1", "drive reversed"])
def test_in_bullet_a_motor_that_fails_takes_the_robot_elsewhere(spec: str) -> None:
    assert in_bullet(spec).distance_to_target_m != in_bullet().distance_to_target_m


@pytest.mark.parametrize("backend", ["kinematic", "pybullet"])
@pytest.mark.parametrize("effect", ["dead", "reversed", "weak=0.1"])
def test_a_wheel_that_does_not_follow_ends_the_run_by_its_motors_name(
    wheels: Wheels, backend: str, effect: str
) -> None:
    if backend == "pybullet":
        pytest.importorskip("pybullet")
    result = search(f"left_motor {effect} after=1", backend=backend, timeout_s=30.0)
    assert (result.outcome, result.exit_status) == (Outcome.STOPPED, 4)
    assert result.reason.startswith("left_motor was commanded to turn ")
    assert "right_motor" not in result.reason
    assert set(wheels.values()) <= {0.0}


def test_every_effect_is_run_here() -> None:
    names = {spec.split()[1].partition("=")[0] for spec in SPECS}
    assert names == {name.partition(".")[0] for name in fault_names()}


def test_a_fault_that_never_begins_changes_nothing() -> None:
    every = [load_fault(name).example.split()[:2] for name in fault_names()]
    later = [f"{target} {effect} after=1000" for target, effect in every]
    assert search(*later).trace_sha256 == search().trace_sha256


def test_a_motor_that_is_weak_in_part_of_a_search_is_made_up_for() -> None:
    result = search("left_motor weak=0.6", "camera drop=0.2 after=5", timeout_s=60.0)
    assert (result.outcome, result.verified) == (Outcome.SUCCESS, True)
    assert result.faults == ["left_motor weak=0.6", "camera drop=0.2 after=5"]


def test_a_stall_that_is_longer_than_the_lease_is_cut_by_the_deadman() -> None:
    plain, stalled = search(), search("loop stall=0.4 after=1 every=1")
    assert stalled.overruns == 2
    assert stalled.interventions >= plain.interventions + 1
    assert stalled.ticks < plain.ticks


LIVING_ON = """
from robotcore import Behaviour, Role, Status
from robotcore.errors import DeviceError

class LivingOn(Behaviour):
    needs = frozenset({Role.DRIVE, Role.RANGE})

    def step(self, robot):
        try:
            is_there = robot.drive.pose.x > 0.3
            robot.drive.set_velocity(0.2, 0.0)
        except DeviceError:
            STOP
            self.state = "waiting"
            return Status.RUNNING
        self.state = "driving"
        return Status.SUCCESS if is_there else Status.RUNNING
"""


def live_on(folder: Path, stop: str, *faults: str) -> RunResult:
    app = folder / "living_on.py"
    app.write_text(LIVING_ON.replace("STOP", stop))
    return run(RunRequest(str(app), world="open", timeout_s=5.0, faults=faults))


def test_an_app_that_stops_lives_through_a_lost_connection(wheels: Wheels, tmp_path: Path) -> None:
    plain = live_on(tmp_path, "robot.drive.stop()")
    result = live_on(tmp_path, "robot.drive.stop()", "connection lost=1 after=0.5")
    assert (result.outcome, result.reason) == (Outcome.SUCCESS, "")
    assert plain.sim_time_s + 0.9 < result.sim_time_s < plain.sim_time_s + 1.3
    assert wheels == {"left_motor": 0.0, "right_motor": 0.0}


def test_a_range_sensor_that_always_tells_the_same_is_named_before_it_leads_into_something() -> None:
    result = search("range stuck=1.5 after=5", timeout_s=30.0)
    assert (result.outcome, result.exit_status, result.contacts) == (Outcome.STOPPED, 4, 0)
    assert result.reason.startswith("nose measured the same 1.50 m while the wheels drove 0.5")


def test_an_encoder_that_fails_is_reported_to_an_app_that_asks_for_the_pose(tmp_path: Path) -> None:
    result = live_on(tmp_path, "raise", "left_encoder lost=1 after=0.5")
    assert result.exit_status == 3
    assert result.reason == 'left_encoder: the connection is lost, by the fault "left_encoder lost=1 after=0.5"'


@pytest.mark.parametrize("instead", ["pass", "robot.drive.stop(); robot['left_motor'].set_velocity(1.0)"])
def test_where_a_wheel_may_still_turn_or_is_to_turn_a_lost_connection_ends_the_run(
    wheels: Wheels, tmp_path: Path, instead: str
) -> None:
    result = live_on(tmp_path, instead, "connection lost=1 after=0.5")
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert result.reason.endswith('the connection is lost, by the fault "connection lost=1 after=0.5"')
    assert wheels == {"left_motor": 0.0, "right_motor": 0.0}
