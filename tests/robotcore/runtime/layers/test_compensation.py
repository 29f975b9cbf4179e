"""A run compensates the constant errors that a robot's file describes, in a simulator and on a robot."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from robotcore import Behaviour, Robot, Role, RunRequest, Status, run
from robotcore.description import RobotDescription, load_robot
from robotcore.hal.clock import SteppedClock
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.range_sensor import Range
from robotcore.runtime.layers.base import MotorOutput
from robotcore.runtime.layers.compensation import CompensationLayer
from robotcore.testing import MockRobot
from tests.robotcore.description.files import ROVER
from tests.robotcore.fakes import NullRange

WORN = {"dead_band_rad_s": 2.0, "forward_gain": 0.9, "backward_gain": 1.2}


def describe(**changes: dict[str, float]) -> RobotDescription:
    rover = load_robot("rover")
    devices = tuple(device.model_copy(update=changes.get(device.name, {})) for device in rover.devices)
    return rover.model_copy(update={"devices": devices})


def command(description: RobotDescription, rad_s: float) -> tuple[float, float]:
    """Return the command that reaches the motor, and the velocity that the layer returns."""
    sent: list[float] = []

    def accept(velocity: float) -> float:
        sent.append(max(-12.0, min(velocity, 12.0)))
        return sent[-1]

    layer = CompensationLayer(description)
    output = layer.motor(MotorOutput("left_motor", accept, lambda: None))
    returned = output.set_velocity(rad_s)
    return sent[0], returned


@pytest.mark.parametrize("rad_s", [0.05, 3.0, 10.0, -0.05, -6.0, -12.0])
def test_the_wheel_turns_as_commanded(rad_s: float) -> None:
    description = describe(left_motor=WORN)
    motor: MotorDescription = next(each for each in description.all_of(MotorDescription) if each.name == "left_motor")
    sent, returned = command(description, rad_s)
    assert motor.respond(sent) == pytest.approx(rad_s)
    assert returned == pytest.approx(rad_s)


def test_a_stop_stays_a_stop() -> None:
    assert command(describe(left_motor=WORN), 0.0) == (0.0, 0.0)


def test_a_velocity_beyond_the_reach_returns_the_velocity_of_the_wheel() -> None:
    assert command(describe(left_motor=WORN), 12.0) == pytest.approx((12.0, 10.8))


def test_a_motor_without_errors_gets_the_command_itself() -> None:
    output = MotorOutput("left_motor", float, lambda: None)
    assert CompensationLayer(load_robot("rover")).motor(output) is output


def test_the_offset_of_a_range_sensor_is_subtracted() -> None:
    clock = SteppedClock(20, lambda steps: None)
    layer, nose = CompensationLayer(describe(nose={"offset_m": 0.03})), NullRange(clock)
    readings = iter((1.03, 0.03, math.inf))
    read = layer.sensor(nose, lambda: Range(next(readings), 0.0, 0))
    assert [read().distance for _ in range(3)] == pytest.approx([1.0, nose.min_range, math.inf])


def test_a_sensor_that_reads_too_little_returns_its_minimum_for_a_body_that_may_be_nearer() -> None:
    description = describe(nose={"offset_m": -0.14})
    nose = NullRange(SteppedClock(20, lambda steps: None))
    readings = iter((nose.min_range, 0.03))
    read = CompensationLayer(description).sensor(nose, lambda: Range(next(readings), 0.0, 0))
    assert [read().distance for _ in range(2)] == pytest.approx([nose.min_range, 0.17])
    assert description.guard_distance_m > 0.14 + nose.min_range


def test_a_sample_that_is_read_again_is_the_same_object_without_its_offset() -> None:
    layer, nose = CompensationLayer(describe(nose={"offset_m": 0.03})), NullRange(SteppedClock(20, lambda steps: None))
    samples = iter([Range(1.03, 0.0, 0), Range(1.03, 0.0, 0), Range(1.03, 0.1, 1)])
    read = layer.sensor(nose, lambda: next(samples))
    first, again, new = (read() for _ in range(3))
    assert first is again
    assert new.sequence == 1


def read_each(*distances: float, loss: float = 0.05, period: float = 0.06, **changes: float) -> list[float]:
    """Return the distances that an app reads from a sensor that loses echoes, for these measurements."""
    layer = CompensationLayer(describe(nose={"loss": loss, **changes}))
    samples = iter([Range(distance, period * index, index) for index, distance in enumerate(distances)])
    read = layer.sensor(NullRange(SteppedClock(20, lambda steps: None)), lambda: next(samples))
    return [read().distance for _ in distances]


def test_lost_echoes_make_no_sample() -> None:
    assert read_each(0.5, math.inf, 0.4, math.inf, math.inf, 0.3) == [0.5, 0.5, 0.4, 0.4, 0.4, 0.3]


def test_a_repeated_echo_is_the_sample_of_its_measurement() -> None:
    layer = CompensationLayer(describe(nose={"loss": 0.05}))
    samples = iter([Range(0.5, 0.0, 7), Range(math.inf, 0.06, 8)])
    read = layer.sensor(NullRange(SteppedClock(20, lambda steps: None)), lambda: next(samples))
    assert read() is read()


@pytest.mark.parametrize("loss, repeats", [(0.02, 1), (0.05, 2), (0.2, 4)])
def test_more_missing_echoes_than_are_lost_in_a_row_show_that_nothing_is_in_range(loss: float, repeats: int) -> None:
    assert read_each(0.5, *[math.inf] * 6, loss=loss) == [0.5] * (1 + repeats) + [math.inf] * (6 - repeats)


def test_a_measurement_that_is_read_twice_counts_once() -> None:
    layer = CompensationLayer(describe(nose={"loss": 0.02}))
    samples = iter([Range(0.5, 0.0, 0), *[Range(math.inf, 0.06, 1)] * 2, Range(math.inf, 0.12, 2)])
    read = layer.sensor(NullRange(SteppedClock(20, lambda steps: None)), lambda: next(samples))
    assert [read().distance for _ in range(4)] == [0.5, 0.5, 0.5, math.inf]


def test_a_sensor_that_has_received_no_echo_returns_its_samples() -> None:
    assert read_each(math.inf, math.inf, 0.5) == [math.inf, math.inf, 0.5]


@pytest.mark.parametrize("changes", [{"period": 1.5}, {"latency_s": 0.6}])
def test_a_lost_echo_of_a_slow_or_late_sensor_does_not_free_the_way(changes: dict[str, float]) -> None:
    assert read_each(0.5, *[math.inf] * 4, loss=0.3, **changes) == [0.5] * 5


def test_after_a_pause_without_readings_no_old_echo_is_returned() -> None:
    layer = CompensationLayer(describe(nose={"loss": 0.2}))
    samples = [Range(0.5, 0.0, 0), Range(math.inf, 1.5, 30), Range(0.4, 1.55, 31), Range(math.inf, 1.6, 32)]
    read = layer.sensor(NullRange(SteppedClock(20, lambda steps: None)), iter(samples).__next__)
    assert [read().time for _ in samples] == [0.0, 1.5, 1.55, 1.55]


def test_samples_of_a_recording_are_compensated_already() -> None:
    nose = NullRange(SteppedClock(20, lambda steps: None))
    nose.is_compensated = True
    assert CompensationLayer(describe(nose={"loss": 0.05, "offset_m": 0.1})).sensor(nose, nose.read) == nose.read


class Charge(Behaviour):
    """Drives straight ahead."""

    needs = frozenset({Role.DRIVE, Role.RANGE})

    def step(self, robot: Robot) -> Status:
        robot.drive.set_velocity(0.2, 0.0)
        return Status.RUNNING


def write_nose(folder: Path, **values: float) -> str:
    keys = "".join(f"{key} = {value}\n" for key, value in values.items())
    file = folder / "robot.toml"
    file.write_text(ROVER.replace('name = "nose"\n', f'name = "nose"\n{keys}', 1))
    return str(file)


@pytest.mark.parametrize(
    "values",
    [
        {"loss": 0.3},
        {"loss": 0.05, "latency_s": 0.5},
        {"loss": 0.2, "rate_hz": 5.0},
        {"loss": 0.5},
        {"offset_m": -0.14},
        {"offset_m": -1.0},
    ],
)
def test_the_range_guard_stops_a_robot_whose_sensor_loses_echoes_or_reads_too_little(
    values: dict[str, float], tmp_path: Path
) -> None:
    request = RunRequest(Charge, robot=write_nose(tmp_path, **values), world="arena", timeout_s=30.0)
    for seed in range(3):
        assert run(replace(request, seed=seed)).contacts == 0


def test_a_script_has_the_readings_of_the_app() -> None:
    readings = list[float]()
    robot = MockRobot(describe(nose={"loss": 0.05, "offset_m": 0.1}), range=[1.0, 0.5, math.inf])

    class Read(Behaviour):
        needs = frozenset({Role.RANGE})

        def step(self, robot: Robot) -> Status:
            readings.append(robot.range.read().distance)
            return Status.RUNNING

    robot.run(Read(), ticks=3)
    assert readings == [1.0, 0.5, math.inf]


class Straight(Behaviour):
    """Drives straight ahead for two seconds."""

    needs = frozenset({Role.DRIVE})

    def step(self, robot: Robot) -> Status:
        robot.drive.set_velocity(0.2, 0.0)
        pose = robot.drive.pose
        self.reason = f"{pose.x:.4f} {pose.y:.4f}"
        return Status.SUCCESS if robot.clock.now() >= 2.0 else Status.RUNNING


@pytest.mark.parametrize("backend", ["kinematic", "mujoco"])
def test_a_robot_with_uneven_motors_drives_straight(backend: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    file = tmp_path_factory.mktemp("worn") / "worn.toml"
    keys = "\n".join(f"{key} = {value}" for key, value in WORN.items())
    file.write_text(ROVER.replace('name = "left_motor"\n', f'name = "left_motor"\n{keys}\n', 1))
    result = run(RunRequest(Straight, backend, robot=str(file), world="open"))
    x, y = map(float, result.reason.split())
    assert x == pytest.approx(0.38, abs=0.03)
    assert abs(y) < 0.005
