"""A bumper is simulated from the simulation's state: every simulator in this process has it, and no remote scene."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pytest

import robotcore
from robotcore import Behaviour, Outcome, Robot, Role, RunRequest, Status
from robotcore.cli.main import execute
from robotcore.description import load_robot, load_world
from robotcore.errors import UsageError
from robotcore.kinds import Bumper
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scenes import default_scene, described_scene
from tests.robotcore.description.files import ROVER
from tests.texts import CheckText, Raises

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


def write_bumper_rover(folder: Path, section: str = "") -> str:
    """Write the file of a rover with two bumpers, and without the range sensor that would stop it before a wall."""
    rover = re.sub(r'\[\[devices\]\]\nkind = "range_sensor".*?\n\n', "", ROVER, flags=re.DOTALL)
    rover = re.sub(r"\[\w+\.nose\].*?(\n\n|\Z)", "", rover, flags=re.DOTALL)
    file = folder / "bumpy.toml"
    file.write_text(rover + BUMPERS + section)
    return str(file)


@pytest.fixture
def robot(tmp_path: Path) -> str:
    return write_bumper_rover(tmp_path)


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


class Wish(Bump):
    """Counts the bumpers, and ends."""

    needs: ClassVar = {Role.DRIVE}
    wants: ClassVar = {Bumper}

    def step(self, robot: Robot) -> Status:
        self.reason = f"{len(robot.all(Bumper))} bumpers"
        return Status.SUCCESS


@pytest.mark.parametrize("backend", ["coppeliasim", "vrep"])
def test_app_that_needs_a_bumper_is_refused_by_the_simulators_of_scenes(
    robot: str, backend: str, raises: Raises
) -> None:
    with raises(UsageError, "device-not-openable", device="front"):
        robotcore.run(RunRequest(Bump, robot=robot, backend=backend, world="arena"))


@pytest.fixture
def scene() -> Simulator:
    """The double of a scene with the objects of the shipped rover."""
    return described_scene(load_robot("rover"), load_world("open"))


@pytest.mark.slow
def test_app_that_only_wants_a_bumper_runs_in_scenes_without_it(robot: str, scene: Simulator) -> None:
    with Double(default_scene()) as double:
        options = {"port": double.zmq_port}
        built = robotcore.run(RunRequest(Wish, robot=robot, backend="coppeliasim", world="open", options=options))
    with Double(scene) as double:
        joined = robotcore.run(RunRequest(Wish, robot=robot, backend="vrep", options={"port": double.legacy_port}))
    assert (built.reason, joined.reason) == ("0 bumpers", "0 bumpers")


def test_check_warns_that_a_scene_has_no_bumper(
    robot: str, scene: Simulator, capfd: pytest.CaptureFixture[str], check_text: CheckText
) -> None:
    file = Path(robot)
    file.write_text(re.sub(r"\[(raspberrypi|serial)\.\w+\].*?\n\n", "", file.read_text(), flags=re.DOTALL))
    assert execute(["check", robot]) == 0
    check_text(capfd.readouterr().out)
    with Double(scene) as double:
        assert execute(["check", robot, "--backend", "vrep", "--port", str(double.legacy_port)]) == 0
    check_text(capfd.readouterr().out)
