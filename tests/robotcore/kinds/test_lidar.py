"""A lidar is simulated by rays, recorded, replayed, written to a table, and may have faults."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, cast

import numpy as np
import pytest
from mcap.reader import make_reader

import robotcore
from drivers.kinematic.backend import KinematicBackend
from drivers.mujoco.backend import MujocoBackend
from drivers.pybullet.backend import PyBulletBackend
from robotcore import Behaviour, Outcome, Robot, Role, RunRequest, Status
from robotcore.cli.main import execute
from robotcore.description import Mount, RobotDescription, load_robot
from robotcore.errors import UsageError
from robotcore.hal.kind import build_sensor
from robotcore.kinds import Lidar
from robotcore.kinds.lidar import LidarDescription, Scan
from robotcore.recording import read as read_recording
from robotcore.recording.codec import read_fields
from robotcore.recording.recorder import Recorder
from robotcore.testing import MockRobot, TestSupport
from robotcore.testing.kind_rules import KindRules
from robotcore.testing.time_rules import SampleRules
from tests.robotcore.description.files import ROVER, find_errors
from tests.texts import CheckText, Raises

SIMULATORS = ["kinematic", "mujoco", "pybullet"]

HEIGHT, RADIUS = 0.12, 0.2

LIDAR = f"""
[[devices]]
kind = "lidar"
name = "scanner"
mount = {{ x_m = 0.02, y_m = 0.01, z_m = {HEIGHT}, yaw_rad = 0.3 }}
min_range_m = 0.12
max_range_m = 3.0
count = 90
"""

SERVO = """
[[devices]]
kind = "servo"
name = "pan"
mount = { x_m = 0.05, z_m = 0.1 }
min_angle_rad = -1.5
max_angle_rad = 1.5
max_velocity_rad_s = 3.0
"""

WORLD = """
name = "room"

[floor]
length_m = 20.0
width_m = 20.0

[start]
x_m = 0.5
y_m = -0.25
yaw_rad = 0.4

[[obstacles]]
name = "pillar"
shape = "cylinder"
colour = "red"
x_m = 1.5
y_m = 0.4
radius_m = 0.2
height_m = 0.5

[[obstacles]]
name = "threshold"
shape = "box"
colour = "white"
x_m = 0.5
y_m = 1.0
length_m = 6.0
width_m = 0.1
height_m = 0.10

[[obstacles]]
name = "wall"
shape = "box"
colour = "white"
x_m = -1.0
y_m = 0.0
length_m = 0.2
width_m = 20.0
height_m = 0.3
"""


@dataclass
class Scanning(Behaviour):
    """Drives for a second, and has the newest scan and the number of scans."""

    needs: ClassVar = {Role.DRIVE, Lidar}
    speed: float = 0.0

    def __init__(self, speed: float = 0.0) -> None:
        self.speed = speed
        self.times: list[float] = []

    def step(self, robot: Robot) -> Status:
        (lidar,) = robot.all(Lidar)
        self.scan, self.bearings, self.mount = lidar.read(), lidar.bearings, lidar.mount
        self.times.append(self.scan.time)
        robot.drive.set_velocity(self.speed, 0.0)
        self.reason = lidar.format_sample(self.scan)
        return Status.RUNNING if robot.clock.now() < 1.0 else Status.SUCCESS


class Turned(Scanning):
    """Turns the lidar's servo."""

    needs: ClassVar = {Role.DRIVE, Lidar, "pan"}

    def step(self, robot: Robot) -> Status:
        robot["pan"].set_angle(0.8)  # type: ignore[attr-defined]
        return super().step(robot)


@pytest.fixture
def robot(tmp_path: Path) -> str:
    file = tmp_path / "scout.toml"
    file.write_text(ROVER + LIDAR)
    return str(file)


@pytest.fixture
def world(tmp_path: Path) -> str:
    file = tmp_path / "room.toml"
    file.write_text(WORLD)
    return str(file)


def measure(app: Scanning) -> list[float]:
    """Return the true distances along the rays, by the closed forms of the wall and the pillar."""
    start = robotcore.Pose(0.5, -0.25, 0.4).compose(app.mount)
    return [_measure_ray(start.x, start.y, start.heading + bearing) for bearing in app.bearings]


def _measure_ray(x: float, y: float, angle: float) -> float:
    dx, dy = math.cos(angle), math.sin(angle)
    to_wall = (-0.9 - x) / dx if dx < 0 else math.inf
    if abs(y + to_wall * dy) > 10.0:
        to_wall = math.inf
    along, beside = (1.5 - x) * dx + (0.4 - y) * dy, (1.5 - x) * dy - (0.4 - y) * dx
    to_pillar = along - math.sqrt(RADIUS**2 - beside**2) if abs(beside) < RADIUS and along > 0 else math.inf
    nearest = min(to_wall, to_pillar)
    return nearest if nearest <= 3.0 else math.inf


@pytest.mark.parametrize("backend", SIMULATORS)
@pytest.mark.parametrize("app", [Scanning, Turned])
def test_each_ray_measures_the_wall_and_the_pillar_at_the_lidars_height(
    robot: str, world: str, backend: str, app: type[Scanning]
) -> None:
    if app is Turned:
        Path(robot).write_text(ROVER + SERVO + LIDAR.replace("z_m", 'on = "pan", z_m'))
    scanning = app()
    result = robotcore.run(RunRequest(scanning, robot=robot, backend=backend, world=world))
    assert result.outcome is Outcome.SUCCESS
    assert scanning.mount.heading == pytest.approx(0.3 + (0.8 if app is Turned else 0.0))
    true = measure(scanning)
    assert sum(map(math.isfinite, true)) > 30
    # A physics engine may model a cylinder with edges, and its robot stands a little lower.
    wrong = [
        (bearing, got, expected)
        for bearing, got, expected in zip(scanning.bearings, scanning.scan.distances, true, strict=True)
        if got != expected and not abs(got - expected) < 0.003
    ]
    assert len(wrong) <= 1, wrong  # a ray at the edge of the pillar


@pytest.mark.parametrize("rate_hz, scans", [(10.0, 11), (5.5, 6)])
def test_lidar_makes_its_number_of_scans_in_a_second(robot: str, rate_hz: float, scans: int) -> None:
    Path(robot).write_text(ROVER + LIDAR + f"rate_hz = {rate_hz}\n")
    app = Scanning()
    robotcore.run(RunRequest(app, robot=robot, backend="kinematic", world="open"))
    assert len(set(app.times)) == scans


def test_noise_has_the_described_deviation(robot: str, world: str) -> None:
    exact, noisy = Scanning(), Scanning()
    robotcore.run(RunRequest(exact, robot=robot, backend="kinematic", world=world))
    Path(robot).write_text(ROVER + LIDAR + "noise_m = 0.02\n")
    robotcore.run(RunRequest(noisy, robot=robot, backend="kinematic", world=world))
    pairs = zip(exact.scan.distances, noisy.scan.distances, strict=True)
    errors = [there - here for here, there in pairs if math.isfinite(here) and math.isfinite(there)]
    assert math.sqrt(sum(each**2 for each in errors) / len(errors)) == pytest.approx(0.02, rel=0.4)


def test_conditions_of_the_world_change_each_distance(robot: str, world: str) -> None:
    exact, noisy = Scanning(), Scanning()
    robotcore.run(RunRequest(exact, robot=robot, backend="kinematic", world=world))
    with Path(world).open("a") as file:
        file.write("\n[conditions]\nrange_noise_m = 0.01\nrange_bias_m = 0.1\n")
    robotcore.run(RunRequest(noisy, robot=robot, backend="kinematic", world=world))
    pairs = zip(exact.scan.distances, noisy.scan.distances, strict=True)
    errors = [there - here for here, there in pairs if math.isfinite(here) and math.isfinite(there)]
    assert sum(errors) / len(errors) == pytest.approx(0.1, abs=0.01)
    assert len(set(errors)) == len(errors) > 20
    assert max(noisy.scan.distances) == math.inf


def test_body_nearer_than_the_minimum_gives_no_echo(robot: str, tmp_path: Path) -> None:
    near = tmp_path / "near.toml"
    near.write_text(WORLD.replace("x_m = 1.5\ny_m = 0.4", "x_m = 0.95\ny_m = -0.05"))
    app = Scanning()
    Path(robot).write_text(ROVER + LIDAR.replace("min_range_m = 0.12", "min_range_m = 0.5"))
    robotcore.run(RunRequest(app, robot=robot, backend="kinematic", world=str(near)))
    assert min(app.scan.distances) > 0.5


@pytest.mark.parametrize(
    "count, start, end, bearings",
    [
        (4, -math.pi, math.pi, (-math.pi, -math.pi / 2, 0.0, math.pi / 2)),
        (3, -0.5, 0.5, (-0.5, 0.0, 0.5)),
        (2, 0.0, math.tau, (0.0, math.pi)),
    ],
)
def test_rays_divide_the_field_of_view_from_right_to_left(
    count: int, start: float, end: float, bearings: tuple[float, ...]
) -> None:
    lidar = LidarDescription(
        kind="lidar",
        name="scanner",
        mount=Mount(z_m=0.1),
        min_range_m=0.1,
        max_range_m=8.0,
        count=count,
        start_rad=start,
        end_rad=end,
    )
    assert lidar.bearings == pytest.approx(bearings)


def test_recorded_run_replays_to_the_bit_and_has_a_column_of_distances(robot: str, world: str, tmp_path: Path) -> None:
    file, app = tmp_path / "run.mcap", Scanning(0.2)
    recorder = Recorder(file)
    robotcore.run(RunRequest(app, robot=robot, backend="kinematic", world=world), [recorder], [recorder.layer])
    samples = [sample for sample in read_recording(file).samples.values() if isinstance(sample, Scan)]
    assert samples[-1].distances == app.scan.distances
    assert math.inf in samples[-1].distances
    assert execute(["info", str(file), "--csv", str(tmp_path / "run.csv")]) == 0
    with (tmp_path / "run.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert tuple(map(float, rows[-1]["scanner_m"].split())) == app.scan.distances
    replayed = Scanning(0.2)
    robotcore.run(RunRequest(replayed, backend="replay", options={"file": str(file)}))
    assert (replayed.scan, replayed.times) == (app.scan, app.times)


def test_recording_shows_the_scans_in_foxglove(robot: str, world: str, tmp_path: Path) -> None:
    file, app = tmp_path / "run.mcap", Scanning()
    recorder = Recorder(file)
    robotcore.run(RunRequest(app, robot=robot, backend="kinematic", world=world), [recorder], [recorder.layer])
    with file.open("rb") as stream:
        messages = [message for *_, message in make_reader(stream).iter_messages(topics=["/scanner/scan"])]
    scan = dict(read_fields(messages[-1].data))
    start, end, ranges = (np.frombuffer(scan[field]) for field in (4, 5, 6))
    assert (start[0], end[0]) == (app.bearings[0], app.bearings[-1])
    assert tuple(ranges) == app.scan.distances


@pytest.mark.parametrize("fault", ["noise=0.05", "bias=0.5", "stuck=1.5", "spikes=0.5 size=0.3"])
def test_fault_changes_each_distance(robot: str, world: str, fault: str) -> None:
    apps = Scanning(), Scanning()
    for app, faults in zip(apps, [(), (f"scanner {fault}",)], strict=True):
        robotcore.run(RunRequest(app, robot=robot, backend="kinematic", world=world, faults=faults))
    exact, faulty = (app.scan.distances for app in apps)
    errors = {round(there - here, 6) for here, there in zip(exact, faulty, strict=True) if math.isfinite(here)}
    if fault == "stuck=1.5":
        assert set(faulty) == {1.5}
    elif fault == "bias=0.5":
        assert errors == {0.5, math.inf}  # some distances come to lie beyond the range
    elif fault.startswith("spikes"):
        assert errors == {-0.3, 0.0, 0.3}
    else:
        assert len(errors) > 20
        assert max(map(abs, errors)) < 0.25


@pytest.mark.parametrize("fault", ["drop=0.5", "freeze after=0.4", "delay=0.2"])
def test_fault_makes_scans_late_or_fewer(robot: str, world: str, fault: str) -> None:
    app = Scanning()
    robotcore.run(RunRequest(app, robot=robot, backend="kinematic", world=world, faults=(f"lidar {fault}",)))
    assert len(set(app.times)) < 10


def test_mock_lidar_plays_distances_and_has_no_echo_without_a_script(robot: str) -> None:
    app = Scanning()
    reading = (0.05, *[1] * 88, 9.0)
    mock = MockRobot(robot, readings={"scanner": [reading]})
    mock.run(app, ticks=1)
    assert app.scan.distances == (math.inf, *[1.0] * 88, math.inf)
    MockRobot(robot).run(app, ticks=1)
    assert set(app.scan.distances) == {math.inf}


@pytest.mark.parametrize("reading", [(1.0, 2.0), (math.nan,) * 90, 0.5], ids=["few", "nan", "number"])
def test_mock_lidar_refuses_other_readings(robot: str, reading: object, raises: Raises) -> None:
    with raises(UsageError, "script-reading", device="scanner"):
        MockRobot(robot, readings={"scanner": [reading]})


@pytest.mark.parametrize(
    "old, new, kind",
    [
        ("min_range_m = 0.12", "min_range_m = 4.0", "ranges-in-wrong-order"),
        ("count = 90", "start_rad = 1.0\nend_rad = 0.5", "field-of-view"),
        ("count = 90", "start_rad = -4.0\nend_rad = 4.0", "field-of-view"),
        ("yaw_rad = 0.3", "pitch_rad = 0.3", "lidar-not-level"),
    ],
)
def test_impossible_lidar_is_refused(old: str, new: str, kind: str, tmp_path: Path, check_text: CheckText) -> None:
    (error,) = find_errors(tmp_path, ROVER + LIDAR.replace(old, new))
    assert error.kind == kind
    check_text(error)


def test_scan_is_formatted_with_its_nearest_distance(robot: str, world: str, check_text: CheckText) -> None:
    app = Scanning()
    robotcore.run(RunRequest(app, robot=robot, backend="kinematic", world=world))
    check_text(app.reason)
    far = Scanning()
    MockRobot(robot).run(far, ticks=1)
    check_text(far.reason)


class Ahead(Behaviour):
    """Drives ahead for 10 s, and uses no lidar itself."""

    needs: ClassVar = {Role.DRIVE}

    def step(self, robot: Robot) -> Status:
        robot.drive.set_velocity(0.3, 0.0)
        self.pose = robot.drive.pose
        return Status.RUNNING if robot.clock.now() < 10.0 else Status.SUCCESS


def write_robot_without_range_sensor(folder: Path, lidar: str = LIDAR) -> str:
    parts = ROVER[: ROVER.index("\n[vrep")].split("[[devices]]")
    file = folder / "scout.toml"
    file.write_text("[[devices]]".join(part for part in parts if "range_sensor" not in part) + lidar)
    return str(file)


def write_world_with_wall(folder: Path, y_m: float = 0.0) -> str:
    file = folder / "walled.toml"
    file.write_text(WORLD.split("[start]", maxsplit=1)[0] + WALL_AHEAD.format(y_m=y_m))
    return str(file)


WALL_AHEAD = """
[[obstacles]]
name = "wall"
shape = "box"
colour = "white"
x_m = 1.1
y_m = {y_m}
length_m = 0.2
width_m = 0.4
height_m = 0.3
"""


@pytest.mark.parametrize("backend", SIMULATORS)
def test_range_guard_stops_a_robot_that_has_only_a_lidar(backend: str, tmp_path: Path) -> None:
    robot, world = write_robot_without_range_sensor(tmp_path), write_world_with_wall(tmp_path)
    app = Ahead()
    result = robotcore.run(RunRequest(app, robot=robot, backend=backend, world=world))
    assert result.intervention_s["range guard"] > 0
    assert result.contacts == 0
    front = app.pose.x + load_robot(robot).body.front_x_m
    assert 0.08 < 1.0 - front < 0.2


@pytest.mark.parametrize("device", ["lidar", "range_sensor"])
def test_range_guard_stops_before_an_obstacle_is_too_near_for_the_sensor(device: str, tmp_path: Path) -> None:
    world = write_world_with_wall(tmp_path)
    if device == "lidar":
        robot = write_robot_without_range_sensor(tmp_path, LIDAR.replace("min_range_m = 0.12", "min_range_m = 0.25"))
    else:
        (tmp_path / "far.toml").write_text(ROVER.replace("min_range_m = 0.02", "min_range_m = 0.3"))
        robot = str(tmp_path / "far.toml")
    result = robotcore.run(RunRequest(Ahead(), robot=robot, backend="kinematic", world=world))
    assert result.contacts == 0
    assert result.intervention_s["range guard"] > 5


@pytest.mark.parametrize("y_m, is_stopped", [(0.3, True), (0.33, False)])
def test_range_guard_ignores_bodies_beside_the_robots_way(y_m: float, is_stopped: bool, tmp_path: Path) -> None:
    robot, world = write_robot_without_range_sensor(tmp_path), write_world_with_wall(tmp_path, y_m)
    result = robotcore.run(RunRequest(Ahead(), robot=robot, backend="kinematic", world=world))
    assert ("range guard" in result.intervention_s) is is_stopped


def test_range_guard_ignores_a_lidar_that_looks_back(tmp_path: Path) -> None:
    back = LIDAR + "start_rad = 1.0\nend_rad = 5.0\n"
    robot, world = write_robot_without_range_sensor(tmp_path, back), write_world_with_wall(tmp_path)
    assert load_robot(robot).sensors_ahead == ()
    result = robotcore.run(RunRequest(Ahead(), robot=robot, backend="kinematic", world=world))
    assert "range guard" not in result.intervention_s


def test_backend_without_lidars_refuses_to_drive_a_robot_whose_lidar_looks_ahead(robot: str, raises: Raises) -> None:
    with raises(UsageError, "device-not-openable", device="scanner"):
        robotcore.run(RunRequest(Ahead, robot=robot, backend="vrep"))


BODY = load_robot("rover").body
LEVEL = Mount(z_m=0.1)


@pytest.mark.parametrize(
    "x_m, y_m, ahead",
    [
        (0.64, 0.0, 0.5),
        (0.64, 0.11, 0.5),
        (0.64, 0.12, math.inf),
        (0.10, 0.0, 0.0),
        (0.08, 0.05, math.inf),
        (0.08, 0.11, math.inf),
        (-0.5, 0.0, math.inf),
    ],
    ids=["ahead", "at-the-edge", "beside", "at-the-front", "own-part", "alongside", "behind"],
)
def test_distance_ahead_is_measured_from_the_front(x_m: float, y_m: float, ahead: float) -> None:
    lidar = cast("Lidar", build_sensor(describe(bearings=math.atan2(y_m, x_m)), lambda: None))
    scan = Scan((math.hypot(x_m, y_m), math.inf), 0.0, 0)
    assert lidar.measure_ahead(scan, LEVEL, BODY) == pytest.approx(ahead)


@pytest.mark.parametrize(
    "start, end, yaw, looks",
    [(-3.14159, 3.14159, 0.0, True), (-1, 1, 2.0, False), (-1, 1, -0.9, True), (2, 5, 3, True)],
)
def test_lidar_looks_ahead_if_a_ray_does(start: float, end: float, yaw: float, *, looks: bool) -> None:
    lidar = describe().model_copy(update={"start_rad": start, "end_rad": end})
    assert lidar.looks_ahead(Mount(z_m=0.1, yaw_rad=yaw)) is looks


def describe(bearings: float = 0.0) -> LidarDescription:
    """Return a lidar with a ray at a bearing and one behind it."""
    return LidarDescription(
        kind="lidar",
        name="scanner",
        mount=LEVEL,
        min_range_m=0.05,
        max_range_m=8.0,
        count=2,
        start_rad=bearings,
        end_rad=bearings + math.pi,
    )


class _LidarSuite(KindRules, SampleRules):
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: "a simulator has no hardware"}

    @property
    def description(self) -> RobotDescription:
        rover = load_robot("rover")
        lidar = LidarDescription(
            kind="lidar", name="scanner", mount=Mount(z_m=0.12), min_range_m=0.1, max_range_m=3.0, noise_m=0.05
        )
        return rover.model_copy(update={"devices": (*rover.devices, lidar)})


@pytest.mark.conformance
class TestKinematic(_LidarSuite):
    backend = KinematicBackend


@pytest.mark.conformance
class TestMujoco(_LidarSuite):
    backend = MujocoBackend


@pytest.mark.conformance
class TestPyBullet(_LidarSuite):
    backend = PyBulletBackend
