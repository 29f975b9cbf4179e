"""An IMU is simulated from the simulation's state, with errors that the seed of the run determines."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import pytest

import robotcore
from robotcore import Behaviour, Outcome, Robot, Role, RunRequest, Status
from robotcore.geometry import wrap_angle
from robotcore.kinds import Imu
from robotcore.kinds.imu import ImuSample
from robotcore.recording.csv_table import write_csv
from robotcore.recording.replay import replay
from robotcore.testing import MockRobot
from tests.robotcore.description.files import ROVER
from tests.robotcore.recording.replay.memory import record_run

SIMULATORS = ["kinematic", "mujoco", "pybullet"]
PERIOD_S = 0.05


@dataclass
class Circle(Behaviour):
    """Drives with a constant twist, and keeps the samples of the IMU and the true heading after the last of them."""

    needs: ClassVar = {Role.DRIVE, Imu}
    samples: ClassVar[list[ImuSample]] = []
    ticks: int = 60
    linear: float = 0.2
    angular: float = 0.5

    def step(self, robot: Robot) -> Status:
        (imu,) = robot.all(Imu)
        self.samples.append(imu.read())
        if len(self.samples) >= self.ticks:
            self.reason = f"{imu.read().heading:.6f}"
            return Status.SUCCESS
        robot.drive.set_velocity(self.linear, self.angular)
        return Status.RUNNING


Drive = Callable[..., list[ImuSample]]


@pytest.fixture
def robot(tmp_path: Path) -> Callable[..., str]:
    def write(**errors: float) -> str:
        keys = "".join(f"{key} = {value}\n" for key, value in errors.items())
        file = tmp_path / "imu.toml"
        file.write_text(f'{ROVER}\n[[devices]]\nkind = "imu"\nname = "imu"\n{keys}')
        return str(file)

    return write


@pytest.fixture
def drive(robot: Callable[..., str]) -> Drive:
    """Return a function that drives, and returns the samples of the IMU."""

    def run(
        backend: str = "kinematic", seed: int = 1, errors: dict[str, float] | None = None, **settings: float
    ) -> list[ImuSample]:
        Circle.samples.clear()
        file = robot(**errors or {})
        request = RunRequest(Circle, robot=file, backend=backend, world="open", seed=seed, settings=settings)
        assert robotcore.run(request).outcome is Outcome.SUCCESS
        return list(Circle.samples)

    return run


@pytest.mark.parametrize("backend", SIMULATORS)
def test_circle_has_the_turn_rate_the_heading_and_the_acceleration_to_its_centre(drive: Drive, backend: str) -> None:
    samples = drive(backend)
    steady = samples[40:]
    accuracy = 1e-6 if backend == "kinematic" else 0.03
    assert {each.sequence for each in samples} == set(range(60))
    for each in steady:
        assert each.yaw_rate == pytest.approx(0.5, abs=accuracy)
        assert each.left_acceleration == pytest.approx(0.2 * 0.5, abs=accuracy)
        assert each.forward_acceleration == pytest.approx(0.0, abs=10 * accuracy)
    turned = wrap_angle(steady[-1].heading - steady[0].heading)
    assert turned == pytest.approx(0.5 * (steady[-1].time - steady[0].time), abs=accuracy)


@pytest.mark.parametrize("backend", SIMULATORS)
def test_integrated_forward_acceleration_is_the_velocity(drive: Drive, backend: str) -> None:
    samples = drive(backend, linear=0.2, angular=0.0)
    assert samples[0].forward_acceleration == 0.0
    gained = sum(each.forward_acceleration for each in samples) * PERIOD_S
    assert gained == pytest.approx(0.2, abs=0.005)


def test_heading_counts_from_the_opening_to_both_sides_of_pi(drive: Drive) -> None:
    samples = drive(linear=0.0, angular=1.5)
    assert samples[0].heading == 0.0
    assert max(each.heading for each in samples) <= math.pi
    assert min(each.heading for each in samples) < -1.0


def test_bias_is_added_to_the_turn_rate_and_integrated_in_the_heading(drive: Drive) -> None:
    exact, biased = drive(), drive(errors={"yaw_rate_bias_rad_s": -0.02})
    for one, other in zip(exact, biased, strict=True):
        assert other.yaw_rate - one.yaw_rate == pytest.approx(-0.02)
        assert wrap_angle(other.heading - one.heading) == pytest.approx(-0.02 * one.time, abs=1e-12)
        assert (other.forward_acceleration, other.left_acceleration) == (
            one.forward_acceleration,
            one.left_acceleration,
        )


NOISE = {"yaw_rate_noise_rad_s": 0.01, "acceleration_noise_m_s2": 0.05, "heading_noise_rad": 0.002}


@pytest.mark.slow
def test_noise_has_its_deviation_and_is_that_of_the_seed(drive: Drive) -> None:
    rest = {"linear": 0.0, "angular": 0.0, "ticks": 500}
    samples = drive(errors=NOISE, **rest)

    def deviation(values: list[float]) -> float:
        return math.sqrt(sum(value**2 for value in values) / len(values))

    assert deviation([each.yaw_rate for each in samples]) == pytest.approx(0.01, rel=0.1)
    assert deviation([each.forward_acceleration for each in samples]) == pytest.approx(0.05, rel=0.1)
    assert deviation([each.left_acceleration for each in samples]) == pytest.approx(0.05, rel=0.1)
    drift = 0.0
    errors = []
    for each in samples:
        drift += each.yaw_rate * PERIOD_S if each.time else 0.0
        errors.append(each.heading - drift)
    assert deviation(errors) == pytest.approx(0.002, rel=0.1)
    assert drive(errors=NOISE, **rest) == samples
    assert drive(errors=NOISE, seed=2, **rest) != samples


TURN = """
from robotcore import Behaviour, Role, Status
from robotcore.kinds import Imu

class Turn(Behaviour):
    needs = {Role.DRIVE, Imu}

    def step(self, robot):
        heading = robot["imu"].read().heading
        robot.drive.set_velocity(0.0, 1.6 - heading)
        return Status.SUCCESS if heading > 1.5 else Status.RUNNING
"""


def test_run_with_an_imu_is_replayed_and_has_its_values_in_a_table(
    robot: Callable[..., str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # a replay runs only apps of the current folder
    (tmp_path / "turn.py").write_text(TURN)
    recording = record_run("turn.py", robot=robot(**NOISE), world="open", seed=3)
    assert recording.result
    assert recording.result.outcome is Outcome.SUCCESS
    assert replay(recording).exit_status == 0
    with write_csv(recording, tmp_path, "run").open() as file:
        last = list(csv.DictReader(file))[-1]
    assert float(last["imu_heading_rad"]) > 1.5
    assert {"imu_yaw_rate_rad_s", "imu_forward_acceleration_m_s2", "imu_left_acceleration_m_s2"} <= last.keys()


def test_fault_adds_a_bias_to_one_value(robot: Callable[..., str]) -> None:
    Circle.samples.clear()
    request = RunRequest(Circle, robot=robot(), world="open", faults=("imu bias=0.1 field=yaw_rate",))
    assert robotcore.run(replace(request, settings={"angular": 0.0})).outcome is Outcome.SUCCESS
    assert {(each.yaw_rate, each.heading) for each in Circle.samples} == {(0.1, 0.0)}


def test_mock_plays_turn_rates(robot: Callable[..., str]) -> None:
    Circle.samples.clear()
    mock = MockRobot(robot(), readings={"imu": [{"yaw_rate": 0.1}, {"yaw_rate": 0.2, "heading": 0.01}]})
    mock.run(Circle(), ticks=2)
    assert [(each.yaw_rate, each.heading) for each in Circle.samples] == [(0.1, 0.0), (0.2, 0.01)]
