from __future__ import annotations

import pytest

from drivers.kinematic.backend import KinematicBackend
from robotcore.description import Start, load_robot, load_world, world_names
from robotcore.errors import DeviceGroupError, UsageError
from robotcore.hal.backend import Setup
from robotcore.kinds.display import Display
from robotcore.kinds.motor import MotorDescription
from tests.drivers.kinematic.rooms import ROVER, ball, get_truth, open_robot, room, sleep
from tests.texts import Raises


@pytest.mark.parametrize("world", world_names())
def test_every_shipped_world_opens(world: str) -> None:
    with open_robot(load_world(world)) as robot:
        assert robot.camera.read().image.any()
        assert robot.range.read().distance > 0


def test_a_single_motor_turns_the_robot_about_the_other_wheel() -> None:
    with open_robot(devices={"right_motor"}) as robot:
        robot.motors["right_motor"].set_velocity(4.0)
        sleep(robot, 1.0)
        assert get_truth(robot).pose().heading > 0.5


def test_robot_without_a_drive_stays_at_the_start() -> None:
    world = room(ball(1.0, 0.0), start=Start(x_m=0.2, yaw_rad=0.1))
    with open_robot(world, load_robot("lookout")) as robot:
        sleep(robot, 1.0)
        truth = get_truth(robot)
        assert (truth.pose(), truth.twist(), truth.contacts()) == ((0.2, 0.0, 0.1), (0.0, 0.0), 0)
        assert robot.camera.read().time == 1.0
        assert isinstance(robot.display, Display)


def test_motor_outside_the_drive_does_not_move_the_robot() -> None:
    fan = MotorDescription(kind="motor", name="fan", max_velocity_rad_s=50.0)
    with open_robot(robot=ROVER.model_copy(update={"devices": (*ROVER.devices, fan)})) as robot:
        assert robot.motors["fan"].set_velocity(80.0) == 50.0
        sleep(robot, 1.0)
        assert get_truth(robot).pose() == (0.0, 0.0, 0.0)


def test_every_encoder_without_a_wheel_is_named(raises: Raises) -> None:
    drive = ROVER.drive.model_copy(update={"left_encoder": None, "right_encoder": None}) if ROVER.drive else None
    with raises(DeviceGroupError):
        open_robot(robot=ROVER.model_copy(update={"drive": drive}))


def test_missing_world_is_refused(raises: Raises) -> None:
    with raises(UsageError, "world-missing"):
        KinematicBackend().open(Setup(ROVER, None, frozenset()))
