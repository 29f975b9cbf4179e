"""The app teleop stands until a person drives, and drives by the robot's gamepads."""

from __future__ import annotations

from pathlib import Path

import pytest

from apps.teleop import Teleop
from robotcore import RunRequest, run
from robotcore.errors import DeviceLostError
from robotcore.safety.velocity_limits import STOPPED
from robotcore.testing import MockRobot
from tests.robotcore.description.files import ROVER

PAD = '\n[[devices]]\nkind = "gamepad"\nname = "pad"\n'


def write_robot(folder: Path, keys: str = "") -> str:
    file = folder / "driven.toml"
    file.write_text(ROVER + PAD + keys)
    return str(file)


def test_robot_without_a_gamepad_stands() -> None:
    robot, app = MockRobot(), Teleop()
    robot.run(app, ticks=5)
    assert set(robot.wheels) == {STOPPED}
    assert app.state == "stand"


@pytest.mark.parametrize(
    "stick, linear, angular",
    [({"left_y": 1.0}, 0.5, 0.0), ({"left_y": -0.5}, -0.25, 0.0), ({"right_x": -1.0}, 0.0, 0.25), ({}, 0.0, 0.0)],
)
def test_the_sticks_command_ratios_of_the_greatest_velocities(
    tmp_path: Path, stick: dict[str, float], linear: float, angular: float
) -> None:
    robot = MockRobot(write_robot(tmp_path), readings={"pad": [stick]})
    app = Teleop(speed=0.5)
    robot.run(app, ticks=10)
    drive = robot.layered.drive
    twist = drive.geometry.to_twist(robot.wheels[-1])
    assert (twist.linear / drive.max_linear, twist.angular / drive.max_angular) == pytest.approx((linear, angular))
    assert app.state == ("drive" if stick else "stand")


def test_a_lost_gamepad_ends_the_run(tmp_path: Path) -> None:
    robot = write_robot(tmp_path, "script = [{ at_s = 0.0, left_y = 1.0 }]")
    result = run(RunRequest("teleop", robot=robot, world="open", timeout_s=2.0, faults=("pad lost=9 after=1",)))
    assert isinstance(result.error, DeviceLostError)
    assert result.error.device == "pad"
    assert result.sim_time_s == pytest.approx(1.0)
