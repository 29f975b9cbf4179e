"""A simulator repeats the commands of a recorded run at their times."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest

from drivers.kinematic.backend import KinematicBackend
from robotcore.description import RobotDescription, load_robot
from robotcore.errors import DeviceError, DeviceGroupError
from robotcore.fidelity.commands import ServoCommand, WheelCommand
from robotcore.fidelity.motor_conversion import DutyModels, MotorConversion
from robotcore.fidelity.run_data import RunData
from robotcore.fidelity.simulated_run import SimulationInputs, simulate
from robotcore.geometry import Wheels
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.hardware.motor_model import MotorModel
from robotcore.kinds.motor import MotorDescription
from robotcore.testing import worlds
from tests.texts import Raises

ROVER = load_robot("rover")
assert ROVER.drive
RADIUS_M = ROVER.drive.wheel_radius_m
FORWARD, STOPPED = Wheels(6.0, 6.0), Wheels(0.0, 0.0)


def change_motors(robot: RobotDescription, **keys: Any) -> RobotDescription:
    devices = (each.model_copy(update=keys) if isinstance(each, MotorDescription) else each for each in robot.devices)
    return robot.model_copy(update={"devices": tuple(devices)})


QUICK = change_motors(ROVER, lag_s=0.0)
"""A rover whose wheels follow each command at once."""


def repeat(
    commands: Sequence[tuple[float, Wheels]],
    times: Sequence[float],
    robot: RobotDescription = QUICK,
    **others: Any,
) -> RunData:
    inputs = SimulationInputs(ROVER, robot, worlds.empty(), times, [WheelCommand(*each) for each in commands], **others)
    return simulate(KinematicBackend(), inputs).data


def measure_ways(data: RunData) -> list[float]:
    """Return the distance from the start at each tick, in metres."""
    return [math.dist(pose, data.poses[0, :2]) for pose in data.poses[:, :2]]


def test_a_command_within_a_step_takes_effect_at_its_own_time() -> None:
    begin, end = 0.1013, 0.5507  # the steps are 1/240 s long
    data = repeat([(begin, FORWARD), (end, STOPPED)], [0.0, 0.3, 0.8])
    expected = [0.0, 6.0 * RADIUS_M * (0.3 - begin), 6.0 * RADIUS_M * (end - begin)]
    assert measure_ways(data) == pytest.approx(expected, abs=1e-9)


def test_the_pose_is_that_of_a_tick_between_two_steps() -> None:
    times = [0.0, 0.0513, 0.0988, 0.1521]
    ways = measure_ways(repeat([(0.0, FORWARD)], times))
    assert ways == pytest.approx([6.0 * RADIUS_M * time for time in times], abs=1e-9)


def test_a_command_of_a_tick_takes_effect_after_the_measurements_of_the_tick() -> None:
    data = repeat([(0.05, FORWARD)], [0.0, 0.05, 0.1])
    assert measure_ways(data)[1] == 0.0
    assert measure_ways(data)[2] > 0.0
    assert data.angles["left"].times.tolist() == pytest.approx([0.0, 0.05, 0.1])


def test_of_two_commands_at_one_time_the_later_one_holds() -> None:
    assert measure_ways(repeat([(0.05, FORWARD), (0.05, STOPPED)], [0.0, 0.5]))[-1] == 0.0


def convert(robot: RobotDescription, models: DutyModels | None = None) -> dict[str, MotorConversion]:
    return {motor.name: MotorConversion(motor, models) for motor in robot.all_of(MotorDescription)}


RECORDED = MotorModel(forward_rad_s=12.0, backward_rad_s=12.0)
TRUE = MotorModel(forward_rad_s=30.0, backward_rad_s=30.0)


def test_a_wheel_may_turn_faster_than_the_greatest_command() -> None:
    conversions = convert(ROVER, DutyModels(RECORDED, TRUE))
    data = repeat([(0.0, Wheels(12.0, 12.0))], [0.0, 0.5], conversions=conversions)
    assert measure_ways(data)[-1] == pytest.approx(15 * RADIUS_M)


def test_a_greater_reach_does_not_change_the_response_below_it() -> None:
    robot = change_motors(QUICK, dead_band_rad_s=2.0, forward_gain=0.9)
    commands, fast = [(0.0, Wheels(8.0, 8.0))], MotorModel(forward_rad_s=20.0, backward_rad_s=20.0)
    wide = convert(change_motors(ROVER, max_velocity_rad_s=20.0), DutyModels(fast, fast))
    direct = measure_ways(repeat(commands, [0.0, 0.5], robot))
    assert measure_ways(repeat(commands, [0.0, 0.5], robot, conversions=wide)) == pytest.approx(direct)


def test_the_recorded_errors_of_a_wheel_are_compensated_and_those_of_the_simulated_one_are_not() -> None:
    weak = change_motors(QUICK, dead_band_rad_s=2.0, forward_gain=0.9)
    commands = [(0.0, FORWARD)]
    same, other = (repeat(commands, [0.0, 1.0], robot, conversions=convert(weak)) for robot in (weak, QUICK))
    assert measure_ways(same)[-1] == pytest.approx(6.0 * RADIUS_M)
    assert measure_ways(other)[-1] == pytest.approx((2 + 6.0 / 0.9 * 10 / 12) * RADIUS_M)


def test_the_offset_of_a_range_sensor_is_compensated_as_in_the_recorded_run() -> None:
    def shift(offset_m: float) -> RobotDescription:
        devices = (
            each.model_copy(update={"offset_m": offset_m}) if each.name == "nose" else each for each in ROVER.devices
        )
        return ROVER.model_copy(update={"devices": tuple(devices)})

    world = worlds.wall(ROVER.mounts["nose"], 1.0)
    inputs = SimulationInputs(shift(0.1), shift(0.3), world, [0.0, 0.1], [], reads={0: ["nose"]})
    (distance,) = simulate(KinematicBackend(), inputs).data.ranges["nose"].distances[0]
    assert distance == pytest.approx(1.2, abs=1e-3)


def test_the_gains_of_the_wheels_are_those_of_the_world() -> None:
    world = worlds.empty()
    conditions = world.conditions.model_copy(update={"wheel_gain_left": 0.5, "wheel_gain_right": 0.5})
    inputs = SimulationInputs(ROVER, QUICK, world, [0.0, 1.0], [WheelCommand(0.0, FORWARD)])
    slow = replace(inputs, world=world.model_copy(update={"conditions": conditions}))
    assert measure_ways(simulate(KinematicBackend(), slow).data)[-1] == pytest.approx(3.0 * RADIUS_M)


def test_a_camera_is_read_in_the_ticks_of_the_recording_and_turns_with_its_servo() -> None:
    scout = load_robot("scout")
    world = worlds.box(scout.mounts["nose"], 1.0, "red")
    still = SimulationInputs(scout, scout, world, [0.0, 0.5, 1.0], [], reads={0: ["eye"], 2: ["eye"]})
    turned = replace(still, servo_commands=[ServoCommand(0.5, "pan", 1.0)])
    before, after = (simulate(KinematicBackend(), each).data.pictures["eye"].pictures for each in (still, turned))
    assert list(before) == list(after) == [0, 2]
    assert (before[0] == after[0]).all()
    assert (before[2] != after[2]).any()


class BlindBackend(KinematicBackend):
    """A simulator that cannot draw pictures."""

    def open(self, setup: Setup) -> Robot:
        if "eye" in setup.devices:
            raise DeviceGroupError("opening rover", [DeviceError("eye", "no library", kind="no-opengl")])
        return super().open(setup)


class BrokenBackend(KinematicBackend):
    """A simulator that cannot open the robot."""

    def open(self, setup: Setup) -> Robot:
        raise DeviceError("left_motor", "it is on no wheel")


def test_cameras_are_left_out_if_the_simulator_cannot_draw() -> None:
    inputs = SimulationInputs(ROVER, ROVER, worlds.empty(), [0.0, 0.1], [], reads={0: ["eye", "nose"], 1: ["eye"]})
    run = simulate(BlindBackend(), inputs)
    assert (set(run.missing), list(run.data.ranges), list(run.data.pictures)) == ({"eye"}, ["nose"], [])
    assert not simulate(KinematicBackend(), inputs).missing


def test_another_failure_of_the_simulator_is_raised(raises: Raises) -> None:
    with raises(DeviceError):
        simulate(BrokenBackend(), SimulationInputs(ROVER, ROVER, worlds.empty(), [0.0, 0.1], []))
