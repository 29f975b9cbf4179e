"""A line sensor is simulated from the floor's colours, recorded, replayed, and written to a table."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

import robotcore
from robotcore import Behaviour, Outcome, Robot, Role, RunRequest, Status
from robotcore.cli.main import execute
from robotcore.description import COLOURS, Floor, Line, Mount, Texture, WorldDescription
from robotcore.description.floor_colours import FloorColours
from robotcore.errors import UsageError
from robotcore.hal.kind import build_sensor
from robotcore.kinds import LineSensor
from robotcore.kinds.line_sensor import Darkness, LineSensorDescription
from robotcore.recording import read as read_recording
from robotcore.recording.recorder import Recorder
from robotcore.testing import MockRobot
from tests.robotcore.description.files import ROVER
from tests.texts import CheckText, Raises

SIMULATORS = ["kinematic", "mujoco", "pybullet"]
ROW = """
[[devices]]
kind = "line_sensor"
name = "row"
mount = { x_m = 0.1, z_m = 0.01 }
count = 5
spacing_m = 0.02
"""
WORLD = """
name = "lined"

[floor]
length_m = 6.0
width_m = 6.0
colour = "white"

[[lines]]
width_m = 0.03
points_m = [[-1.0, 0.04], [2.0, 0.04]]
"""


@dataclass
class Look(Behaviour):
    """Drives ahead for a second, and gives the position of the line as its reason."""

    needs: ClassVar = {Role.DRIVE, LineSensor}

    def step(self, robot: Robot) -> Status:
        (row,) = robot.all(LineSensor)
        robot.drive.set_velocity(0.2, 0.0)
        self.reason = f"{row.read_position()} {row.read().values}"
        return Status.RUNNING if robot.clock.now() < 1.0 else Status.SUCCESS


def write_line_rover(folder: Path, section: str = "") -> str:
    """Write the file of a rover with a line sensor of five sensors."""
    file = folder / "follower.toml"
    file.write_text(ROVER + ROW + section)
    return str(file)


def write_line_world(folder: Path) -> str:
    """Write the file of a world with a black line along x, 4 cm to the left of the robot."""
    file = folder / "lined.toml"
    file.write_text(WORLD)
    return str(file)


@pytest.fixture
def robot(tmp_path: Path) -> str:
    return write_line_rover(tmp_path)


@pytest.fixture
def world(tmp_path: Path) -> str:
    return write_line_world(tmp_path)


def test_each_sensor_has_noise_of_its_own_within_the_limits(tmp_path: Path, world: str) -> None:
    reasons = []
    for seed in (1, 1, 2):
        robot = write_line_rover(tmp_path, "noise = 0.1\n")
        reasons.append(robotcore.run(RunRequest(Look, robot=robot, world=world, seed=seed)).reason)
    assert reasons[0] == reasons[1] != reasons[2]
    values = eval(reasons[0].partition(" ")[2])  # noqa: S307  the app's own text
    assert len(set(values)) >= 3  # a value below 0 or above 1 is limited
    assert all(0 <= value <= 1 for value in values)


@pytest.mark.parametrize("backend", SIMULATORS)
def test_line_at_the_left_darkens_the_first_sensor(robot: str, world: str, backend: str) -> None:
    result = robotcore.run(RunRequest(Look, robot=robot, backend=backend, world=world))
    white, black = 1 - 235 / 255, 1 - 25 / 255
    position, _, values = result.reason.partition(" ")
    assert float(position) == pytest.approx(0.04)
    assert eval(values) == pytest.approx((black, white, white, white, white))  # noqa: S307  the app's own text


def read(*values: float) -> LineSensor:
    row = LineSensorDescription(
        kind="line_sensor", name="row", mount=Mount(z_m=0.01), count=len(values), spacing_m=0.01
    )
    sensor = build_sensor(row, lambda: Darkness(values, 0.0, 0))
    assert isinstance(sensor, LineSensor)
    return sensor


@pytest.mark.parametrize(
    "values, position",
    [
        ((0.0, 0.0, 1.0), -0.01),
        ((1.0, 1.0, 0.0), 0.005),
        ((1.0, 1.0, 1.0), 0.0),
        ((0.3, 0.3, 0.9), -0.01),
        ((0.3, 0.4, 0.5), None),
    ],
)
def test_position_is_the_mean_of_the_sensors_over_the_line(values: tuple[float, ...], position: float | None) -> None:
    found = read(*values).read_position()
    assert found == (None if position is None else pytest.approx(position))


def test_lower_threshold_finds_a_pale_line() -> None:
    assert read(0.1, 0.4, 0.1).read_position(0.2) == pytest.approx(0.0)


def test_colour_of_a_point_is_that_of_the_last_line_over_the_texture() -> None:
    points = ((-1.0, 0.0), (1.0, 0.0))
    world = WorldDescription(
        name="lined",
        floor=Floor(length_m=4, width_m=4, colour=(200, 100, 50), texture=Texture(pattern="checker", contrast=0.5)),
        lines=(Line(width_m=0.1, points_m=points), Line(width_m=0.05, points_m=points, colour=COLOURS["red"])),
    )
    found = FloorColours(world).measure(np.array([(0.0, 0.02), (0.0, 0.04), (0.01, 0.06), (0.01, 0.13), (1.04, 0.0)]))
    half = 200 * 128 / 255
    assert found[:, 0].tolist() == pytest.approx([200, 25, 200, half, 25])
    assert found[0].tolist() == [200, 40, 35]


def test_recorded_run_replays_to_the_bit_and_has_a_column_of_values(robot: str, world: str, tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    recorder = Recorder(file)
    request = RunRequest(Look, robot=robot, backend="kinematic", world=world)
    result = robotcore.run(request, [recorder], [recorder.layer])
    assert result.outcome is Outcome.SUCCESS
    recording = read_recording(file)
    samples = [sample for sample in recording.samples.values() if isinstance(sample, Darkness)]
    assert f"0.04 {samples[-1].values}" == result.reason
    assert robotcore.run(RunRequest(Look, backend="replay", options={"file": str(file)})).reason == result.reason
    assert execute(["info", str(file), "--csv", str(tmp_path / "run.csv")]) == 0
    with (tmp_path / "run.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert tuple(map(float, rows[-1]["row"].split())) == samples[-1].values


def test_sample_is_formatted_with_two_digits(check_text: CheckText) -> None:
    sensor = read(0.0, 1.0, 1 / 3)
    check_text(sensor.format_sample(sensor.read()))


def test_mock_sensor_plays_tuples_and_is_over_white_without_a_script(robot: str) -> None:
    app = Look()
    mock = MockRobot(robot, readings={"row": [(1, 0, 0, 0, 0), (0.0, 0.0, 0.0, 0.0, 1.0)]})
    mock.run(app, ticks=1)
    assert app.reason == "0.04 (1.0, 0.0, 0.0, 0.0, 0.0)"
    mock.run(app, ticks=1)
    assert app.reason == "-0.04 (0.0, 0.0, 0.0, 0.0, 1.0)"
    MockRobot(robot).run(app, ticks=1)
    assert app.reason == "None (0.0, 0.0, 0.0, 0.0, 0.0)"


@pytest.mark.parametrize("reading", [(1, 0), (0, 0, 0, 0, 2), 0.5], ids=["few", "bright", "number"])
def test_mock_sensor_refuses_other_readings(robot: str, reading: object, raises: Raises) -> None:
    with raises(UsageError, "script-reading", device="row"):
        MockRobot(robot, readings={"row": [reading]})
