"""A bumper is simulated from the ground truth, so every simulator in this process has it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pytest

import robotcore
from robotcore import Behaviour, Outcome, Robot, Role, RunRequest, Status
from robotcore.kinds import Bumper
from tests.robotcore.description.files import ROVER

SIMULATORS = ["kinematic", "mujoco", "pybullet"]
BUMPERS = """
[[devices]]
kind = "bumper"
name = "front"

[[devices]]
kind = "bumper"
name = "rear"
direction_rad = 3.14159
"""


@dataclass
class Bump(Behaviour):
    """Drives until a bumper is pressed."""

    needs: ClassVar = {Role.DRIVE, Bumper}
    speed_m_s: float = 0.3

    def step(self, robot: Robot) -> Status:
        if pressed := [bumper.name for bumper in robot.all(Bumper) if bumper.read().is_pressed]:
            self.reason = " ".join(pressed)
            return Status.SUCCESS
        robot.drive.set_velocity(self.speed_m_s, 0.0)
        return Status.RUNNING


@pytest.fixture
def robot(tmp_path: Path) -> str:
    """The file of a rover with two bumpers, and without the range sensor that would stop it in front of a wall."""
    rover = re.sub(r'\[\[devices\]\]\nkind = "range_sensor".*?\n\n', "", ROVER, flags=re.DOTALL)
    rover = re.sub(r"\[\w+\.nose\].*?(\n\n|\Z)", "", rover, flags=re.DOTALL)
    file = tmp_path / "bumpy.toml"
    file.write_text(rover + BUMPERS)
    return str(file)


@pytest.mark.parametrize("backend", SIMULATORS)
@pytest.mark.parametrize("speed_m_s, bumper", [(0.3, "front"), (-0.3, "rear")])
def test_only_the_bumper_that_faces_the_wall_is_pressed(
    robot: str, backend: str, speed_m_s: float, bumper: str
) -> None:
    settings = {"speed_m_s": speed_m_s}
    result = robotcore.run(RunRequest(Bump, robot=robot, backend=backend, world="arena", settings=settings))
    assert (result.outcome, result.reason) == (Outcome.SUCCESS, bumper)
    assert result.contacts == 1


def test_injected_fault_presses_the_bumper(robot: str) -> None:
    faults = ("rear stuck=1 after=0.5",)
    result = robotcore.run(RunRequest(Bump, robot=robot, backend="kinematic", world="open", faults=faults))
    assert (result.outcome, result.reason, result.contacts) == (Outcome.SUCCESS, "rear", 0)
    assert result.sim_time_s == pytest.approx(0.5, abs=0.06)


def test_app_needs_a_device_by_name(robot: str) -> None:
    class Front(Bump):
        needs: ClassVar = {Role.DRIVE, "front"}

    assert robotcore.run(RunRequest(Front, robot=robot, backend="kinematic", world="arena")).reason == "front"
