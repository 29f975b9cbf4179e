"""Where straight, turn and arc end, by the truth of the simulator."""

from __future__ import annotations

import math
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

import pytest

from robotcore import Robot, Routine, Status, arc, description, straight, turn
from robotcore.geometry import Pose
from robotcore.testing import MockRobot
from tests.robotcore.autonomy.manoeuvres.driving import Route, RoutineApp, drive, is_at

START = Pose(0.0, 0.0, 0.0)
IMU = """
[[devices]]
kind = "imu"
name = "imu"
yaw_rate_bias_rad_s = 0.02
"""


@pytest.mark.parametrize("rate_hz", [10.0, 20.0, 50.0])
@pytest.mark.parametrize("distance", [0.5, -0.3, 0.02])
def test_straight_ends_at_its_distance_and_on_its_line(distance: float, rate_hz: float) -> None:
    done = drive(lambda robot: straight(robot, distance), rate_hz=rate_hz)
    assert is_at(done.end, Pose(distance, 0.0, 0.0), 0.0015)
    assert is_at(done.returned, done.end)


@pytest.mark.parametrize("rate_hz", [10.0, 20.0, 50.0])
@pytest.mark.parametrize("angle", [math.pi / 2, -0.7, 0.05, 7.0])
def test_turn_ends_at_its_angle_and_place(angle: float, rate_hz: float) -> None:
    done = drive(lambda robot: turn(robot, angle), rate_hz=rate_hz)
    assert is_at(done.end, Pose(0.0, 0.0, angle))
    assert done.returned.heading == pytest.approx(angle, abs=0.005)


@pytest.mark.parametrize("radius, angle", [(0.4, 2.0), (0.3, -math.tau), (0.03, 1.5), (2.0, 0.2)])
def test_arc_ends_at_its_end(radius: float, angle: float) -> None:
    done = drive(lambda robot: arc(robot, radius, angle))
    assert is_at(done.end, START.advance(radius * abs(angle), angle))


@pytest.mark.parametrize("build", [lambda r: straight(r, 0.5), lambda r: turn(r, 1.5), lambda r: arc(r, 0.4, 1.5)])
def test_the_robot_stands_at_the_end_after_a_command_of_zero(build: Route) -> None:
    done = drive(build)
    assert done.sent[-1] == (0.0, 0.0)
    assert done.way.poses[-1].distance_to(*done.way.poses[-2][:2]) < 1e-4


@pytest.mark.parametrize("robot", ["freenove-4wd", "jetbot", "tracer", "bubblerob", "picar"])
def test_straight_and_arc_end_right_on_each_drive(robot: str) -> None:
    assert is_at(drive(lambda robot: straight(robot, 0.4), robot=robot).end, Pose(0.4, 0.0, 0.0))
    assert is_at(drive(lambda robot: straight(robot, -0.4), robot=robot).end, Pose(-0.4, 0.0, 0.0))
    assert is_at(drive(lambda robot: arc(robot, 0.5, -1.0), robot=robot).end, START.advance(0.5, -1.0))


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["mujoco", "pybullet"])
@pytest.mark.parametrize("robot", ["rover", "freenove-4wd", "picar"])
def test_straight_and_arc_end_right_in_physics(robot: str, backend: str) -> None:
    pytest.importorskip(backend)
    done = drive(lambda robot: straight(robot, 0.4), robot=robot, backend=backend)
    assert is_at(done.end, Pose(0.4, 0.0, 0.0))
    done = drive(lambda robot: arc(robot, 0.5, -1.0), robot=robot, backend=backend)
    assert is_at(done.end, START.advance(0.5, -1.0), 0.005, math.radians(0.5))


@pytest.fixture
def uneven(tmp_path: Path) -> str:
    """Return a world in which the wheels of a robot turn at unequal speeds."""
    world = tmp_path / "field.toml"
    floor = "[floor]\nlength_m = 9.0\nwidth_m = 9.0\n"
    world.write_text(f'name = "field"\n{floor}[conditions]\nwheel_gain_left = 1.05\nwheel_gain_right = 0.95\n')
    return str(world)


def test_unequal_wheels_are_corrected_by_the_encoders(uneven: str) -> None:
    def square(robot: Robot) -> Routine[None]:
        for _ in range(4):
            yield from straight(robot, 1.0)
            yield from turn(robot, math.pi / 2)

    assert is_at(drive(square, world=uneven).end, START, 0.02, math.radians(1.0))


def test_a_turn_with_unequal_wheels_holds_its_place(uneven: str) -> None:
    assert is_at(drive(lambda robot: turn(robot, math.pi / 2), world=uneven).end, Pose(0.0, 0.0, math.pi / 2), 0.004)


def test_a_robot_that_steers_turns_its_front_wheels_before_it_drives() -> None:
    done = drive(lambda robot: arc(robot, 0.5, -1.0), robot="picar")
    speeds = [(sent.left + sent.right) / 2 * 0.0325 for sent in done.sent]
    assert speeds[1:7] == pytest.approx([0.001] * 6)
    assert done.sent[1].left > done.sent[1].right
    assert max(speeds) > 0.2


def test_an_imu_corrects_the_heading_of_slipping_wheels(tmp_path: Path) -> None:
    file = tmp_path / "rover.toml"
    file.write_text((files(description) / "robots" / "rover.toml").read_text() + IMU)

    def route(robot: Robot) -> Routine[None]:
        yield from turn(robot, 3.0)
        yield from straight(robot, 0.2)

    done = drive(route, robot=str(file), faults=("encoders slip=0.05",))
    assert done.end.heading == pytest.approx(3.0, abs=math.radians(0.5))
    without = drive(lambda robot: turn(robot, 3.0), faults=("encoders slip=0.05",))
    assert abs(without.end.heading - 3.0) > 0.1


def test_speeds_and_accelerations_stay_within_the_profile() -> None:
    done = drive(lambda robot: straight(robot, 0.6, speed=0.3))
    speeds = [sent.left * 0.0325 for sent in done.sent]
    assert max(speeds) == pytest.approx(0.3, abs=0.003)
    assert max(abs(after - before) for before, after in pairwise(speeds)) < 0.5 / 20 + 0.005
    assert not done.result.interventions


def test_a_turn_rate_is_not_exceeded() -> None:
    done = drive(lambda robot: turn(robot, 2.0, turn_rate=0.5))
    rates = [(sent.right - sent.left) * 0.0325 / 0.155 for sent in done.sent]
    assert max(rates) == pytest.approx(0.5)


def test_default_speeds_are_shares_of_what_the_drive_can() -> None:
    done = drive(lambda robot: straight(robot, 0.6))
    assert max(sent.left for sent in done.sent) == pytest.approx(6.0, abs=0.1)


@pytest.mark.parametrize("build", [lambda r: straight(r, 0.0), lambda r: turn(r, 0.0), lambda r: arc(r, 0.5, 0.0)])
def test_a_way_of_zero_ends_at_once(build: Route) -> None:
    robot = MockRobot()
    assert robot.run(RoutineApp(build), ticks=5) is Status.SUCCESS
    assert len(robot.ticks) == 1


def test_a_routine_that_is_closed_commands_zero() -> None:
    def route(robot: Robot) -> Routine[None]:
        routine = straight(robot, 1.0)
        for _ in range(20):
            next(routine)
            yield
        next(routine)
        routine.close()
        yield

    done = drive(route, robot="tracer")
    assert done.sent[19].left > 5.0
    assert done.sent[20].left < done.sent[19].left - 2.0


def test_coarse_encoders_end_the_corrections(tmp_path: Path) -> None:
    file = tmp_path / "rover.toml"
    text = (files(description) / "robots" / "rover.toml").read_text()
    file.write_text(text.replace("counts_per_turn = 960", "counts_per_turn = 20"))
    done = drive(lambda robot: straight(robot, 0.5), robot=str(file))
    assert is_at(done.end, Pose(0.5, 0.0, 0.0), 0.01, 0.07)
    assert done.result.sim_time_s < 8.0


def test_a_manoeuvre_ends_at_its_place_in_a_loop_of_1_hz() -> None:
    done = drive(lambda robot: straight(robot, 0.3), rate_hz=1.0)
    assert done.end.x == pytest.approx(0.3, abs=0.003)
