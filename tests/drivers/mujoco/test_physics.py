from __future__ import annotations

import math

import pytest

from drivers.mujoco.backend import MujocoBackend
from drivers.mujoco.simulation import Simulation
from robotcore.kinds.motor import Motor, MotorDescription
from tests.drivers.physics import drives, driving, ranging, seeing
from tests.drivers.physics.worlds import ROVER, Thing, ball, box, drive, get_truth, post, setup, world

STEP_S = 1 / 240


class TestDriving(driving.Driving):
    backend = MujocoBackend

    def test_wheels_follow_a_command_with_their_lag_at_every_step(self) -> None:
        with self.open_robot() as robot:
            for step in range(1, 25):
                drive(robot, 1.0, 1.0, STEP_S)
                reached = 0.0325 * (1 - math.exp(-step * STEP_S / 0.05))
                assert get_truth(robot).twist().linear == pytest.approx(reached, rel=0.003), step

    def test_the_truth_is_of_the_current_time_and_not_a_step_old(self) -> None:
        with self.open_robot() as robot:
            drive(robot, 4.0, 4.0, STEP_S)
            truth = get_truth(robot)
        assert truth.pose().x == pytest.approx(truth.twist().linear * STEP_S, rel=1e-3)


@pytest.mark.parametrize(
    "thing",
    [box(0.5), box(0.5, height=0.03), post(0.5), ball(0.5)],
    ids=["wall", "threshold", "post", "ball"],
)
def test_a_robot_climbs_nothing_that_it_drives_into(thing: Thing) -> None:
    simulation = Simulation(setup(world(thing)), world(thing))
    motors = [simulation.open(description) for description in ROVER.all_of(MotorDescription)]
    for motor in motors:
        assert isinstance(motor, Motor)
        motor.set_velocity(12.0)
    simulation.clock.sleep_until(3.0)
    height, (*_, upright) = simulation.data.body("base_link").xpos[2], simulation.data.body("base_link").xmat
    assert simulation.contacts() >= 1
    assert abs(height) < 0.002
    assert upright > math.cos(0.03)


class TestDrives(drives.Drives):
    backend = MujocoBackend


class TestSeeing(seeing.Seeing):
    backend = MujocoBackend


class TestPainting(seeing.Painting):
    backend = MujocoBackend


class TestRenderingAhead(seeing.RenderingAhead):
    backend = MujocoBackend


class TestRanging(ranging.Ranging):
    backend = MujocoBackend


class TestTexturing(seeing.Texturing):
    backend = MujocoBackend
