"""Runs whose encoders are read between two ticks: on a clock whose time passes by itself, and in simulators."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

import robotcore
from robotcore import RunRequest
from robotcore.description import Floor, RobotDescription, Start, WorldDescription, load_robot
from robotcore.errors import DeviceClosedError, DeviceLostError
from robotcore.geometry import Pose, Wheels
from robotcore.hal.backend import Backend, Setup, load_backend
from robotcore.hal.robot import Robot, Role
from robotcore.kinds.encoder import Angle
from robotcore.runtime.behaviour import Status
from robotcore.runtime.layers import AssembledRobot, assemble
from robotcore.runtime.needs import needed_devices
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.session import run
from tests.robotcore.fakes import FunctionApp, NullMotor, NullRange
from tests.robotcore.runs import CallOnce
from tests.robotcore.runtime.layers.test_drive_kinds import ONE_MOTOR, change_drive
from tests.robotcore.runtime.layers.test_encoder_polling import TurningEncoder, UnsteppedClock


class WatchedEncoder(TurningEncoder):
    """An encoder that counts its polls after it was closed, and fails if a function of the time returns True."""

    def __init__(self, name: str, clock: UnsteppedClock, angle_at: Callable[[float], float]) -> None:
        super().__init__(name, clock, angle_at)
        self.fails_at: Callable[[float], bool] = lambda _: False
        self.late_polls = 0
        self._clock = clock

    def read(self) -> Angle:
        if self.fails_at(self._clock.now()):
            raise DeviceLostError(self.name, "unplugged")
        try:
            return super().read()
        except DeviceClosedError:
            self.late_polls += 1
            raise

    def _release(self) -> None:
        self._clock.sleep_until(self._clock.now() + 0.1)  # a poll would come before the encoder is closed


class UnsteppedBackend(Backend):
    """Opens a robot on a clock whose time passes by itself. Its wheels turn by themselves."""

    name = "unstepped"
    summary = "null motors, and encoders that turn by themselves"
    encoder_rate_hz = 200.0

    def open(self, setup: Setup) -> Robot:
        self.clock = UnsteppedClock(setup.rate_hz, lambda _: None)
        self.left = WatchedEncoder("left_encoder", self.clock, lambda time: 2 * time)
        self.right = WatchedEncoder("right_encoder", self.clock, lambda time: 2 * time + math.sin(20 * time))
        devices = [NullMotor("left_motor"), NullMotor("right_motor"), NullRange(self.clock), self.left, self.right]
        return Robot("rover", self.clock, [device for device in devices if device.name in setup.devices])

    def count_polls(self) -> int:
        return len(self.left.times)

    def integrate_pose(self, until: float, steps: int = 20_000) -> Pose:
        """Return the pose by arcs that are much shorter than the polls."""
        geometry = load_robot("rover").drive.geometry  # type: ignore[union-attr]
        pose, step = Pose(0.0, 0.0, 0.0), until / steps
        for index in range(steps):
            middle = (index + 0.5) * step
            twist = geometry.to_twist(Wheels(2.0, 2.0 + 20 * math.cos(20 * middle)))
            pose = pose.advance(twist.linear * step, twist.angular * step)
        return pose


@pytest.fixture
def unstepped(monkeypatch: pytest.MonkeyPatch) -> UnsteppedBackend:
    backend = UnsteppedBackend()
    for module in ("runtime.plan", "interactive.opening"):
        monkeypatch.setattr(f"robotcore.{module}.load_backend", lambda _: backend)
    return backend


def wait_until(seconds: float, poses: list[Pose]) -> FunctionApp:
    """Return an app that stands for a time, and stores the pose of each tick."""

    def step(robot: Robot) -> Status:
        poses.append(robot.drive.pose)
        return Status.RUNNING if robot.clock.now() < seconds else Status.SUCCESS

    return FunctionApp(step)


def perform(app: FunctionApp, **parts: object) -> RunResult:
    return run(RunRequest(app, "unstepped", rate_hz=10), **parts)  # type: ignore[arg-type]


def test_pose_is_exact_on_a_clock_that_is_not_in_lockstep(unstepped: UnsteppedBackend) -> None:
    true, errors = unstepped.integrate_pose(1.0), []
    for rate_hz in (200.0, None):
        vars(unstepped)["encoder_rate_hz"] = rate_hz
        poses: list[Pose] = []
        assert perform(wait_until(1.0, poses)).outcome is Outcome.SUCCESS
        assert poses[-1].heading == pytest.approx(true.heading, abs=1e-6)
        errors.append(poses[-1].distance_to(true.x, true.y))
    assert errors[0] < errors[1] / 20


def test_encoders_are_polled_until_just_before_they_are_closed(unstepped: UnsteppedBackend) -> None:
    perform(wait_until(0.5, []))
    assert unstepped.count_polls() >= 0.5 * 200
    assert (unstepped.left.late_polls, unstepped.right.late_polls) == (0, 0)


def test_polls_end_after_an_exception_of_the_app_too(unstepped: UnsteppedBackend) -> None:
    result = perform(FunctionApp(lambda robot: Status(1 // int(robot.clock.now() < 0.5)) and Status.RUNNING))
    assert result.outcome is Outcome.ERROR
    assert (unstepped.left.late_polls, unstepped.right.late_polls) == (0, 0)


def test_failures_between_two_ticks_do_not_end_a_run(unstepped: UnsteppedBackend) -> None:
    def fail() -> None:
        unstepped.right.fails_at = lambda time: abs(10 * time - round(10 * time)) > 0.01

    poses: list[Pose] = []
    assert perform(wait_until(1.0, poses), observers=[CallOnce(fail)]).outcome is Outcome.SUCCESS
    true = unstepped.integrate_pose(1.0)
    assert poses[-1].heading == pytest.approx(true.heading, abs=1e-6)


def test_failure_of_an_encoder_ends_a_run_with_polls_as_without(unstepped: UnsteppedBackend) -> None:
    def fail() -> None:
        unstepped.right.fails_at = lambda _: True

    result = perform(wait_until(1.0, []), observers=[CallOnce(fail)])
    assert isinstance(result.error, DeviceLostError)
    assert result.error.device == "right_encoder"


def test_pose_is_exact_over_a_pause_of_a_live_robot(unstepped: UnsteppedBackend) -> None:
    with robotcore.open("rover", "unstepped", rate_hz=10) as robot:
        robot.wait(0.5)
        unstepped.clock.sleep_until(0.9)  # a person turns the wheels at the prompt
        assert robot.drive.pose.heading == pytest.approx(unstepped.integrate_pose(0.9).heading, abs=1e-6)
        robot.wait(0.1)
        end = robot.clock.now()
        true = unstepped.integrate_pose(end)
        assert robot.drive.pose.distance_to(true.x, true.y) < 2e-4
    assert (unstepped.left.late_polls, unstepped.right.late_polls) == (0, 0)


FIELD = WorldDescription(name="field", floor=Floor(length_m=60.0, width_m=60.0), start=Start())
SKID = load_robot("freenove-4wd")
WHEELS = ("front_left", "rear_left", "front_right", "rear_right")
ENCODED_SKID = RobotDescription.model_validate(
    {
        **SKID.model_dump(),
        "devices": [
            *SKID.model_dump()["devices"],
            *({"kind": "encoder", "name": f"{wheel}_encoder", "counts_per_turn": 960} for wheel in WHEELS),
        ],
        "drive": {
            **SKID.model_dump()["drive"],
            "left_encoder": [f"{wheel}_encoder" for wheel in WHEELS[:2]],
            "right_encoder": [f"{wheel}_encoder" for wheel in WHEELS[2:]],
        },
    }
)
DRIVES = {
    "two wheels": load_robot("rover"),
    "skid": ENCODED_SKID,
    "steering": load_robot("picar"),
    "steering, one encoder": ONE_MOTOR,
}
"""Robots with encoders and different drives."""


def weave(robot: AssembledRobot, raw: Robot, ticks: int = 40) -> list[Pose]:
    """Command another arc in each third tick, and return the true pose in each tick."""
    poses: list[Pose] = []
    drive, clock = robot.robot.drive, robot.clock
    for tick in range(ticks):
        drive.track()
        assert raw.truth
        poses.append(raw.truth.pose())
        linear, angular = [(0.3, 1.5), (0.3, -1.5), (-0.2, 1.0), (0.3, 0.0)][tick // 3 % 4]
        drive.set_velocity(linear, angular)
        assert robot.command_filter
        robot.command_filter.commit()
        clock.sleep_until((tick + 1) / 10)
    return poses


def weave_on(backend: str, description: RobotDescription, encoder_rate_hz: float | None) -> tuple[list[Pose], float]:
    """Return the true poses, and the distance between the last one and the pose of the odometry."""
    description = change_drive(description, max_acceleration_rad_s2=None)
    raw = load_backend(backend).open(Setup(description, FIELD, needed_devices(description, [Role.DRIVE]), 10))
    robot = assemble(raw, description, 10, encoder_rate_hz=encoder_rate_hz)
    poses = weave(robot, raw)
    pose, start, end = robot.robot.drive.latest_pose, poses[0], poses[-1]
    raw.close()
    return poses, pose.distance_to(*start.to_local(end.x, end.y))


@pytest.mark.parametrize("description", DRIVES.values(), ids=DRIVES)
def test_polls_make_the_odometry_exact_and_do_not_change_the_simulated_motion(description: RobotDescription) -> None:
    poses, error = weave_on("kinematic", description, 200.0)
    same_poses, slow_error = weave_on("kinematic", description, None)
    assert poses == same_poses
    assert error < slow_error / 3


@pytest.mark.parametrize("backend", ["mujoco", "pybullet"])
def test_polls_do_not_change_the_motion_in_a_physics_engine(backend: str) -> None:
    pytest.importorskip(backend)
    poses, same_poses = (weave_on(backend, load_robot("rover"), rate_hz)[0] for rate_hz in (120.0, None))
    assert poses == same_poses
    poses, same_poses = (weave_on(backend, load_robot("picar"), rate_hz)[0] for rate_hz in (120.0, None))
    assert poses == [pytest.approx(pose, abs=1e-9) for pose in same_poses]  # the servo's angle has rounding errors


def test_encoders_on_virtual_pins_are_polled() -> None:
    description = load_robot("rover")
    (poses, error), (same_poses, slow_error) = (weave_on("virtualpi", description, rate) for rate in (200.0, None))
    assert poses == same_poses
    assert error < slow_error / 10


@pytest.mark.parametrize(
    "backend, rate_hz",
    [("raspberrypi", 200), ("serial", 200), ("virtualpi", 200), ("kinematic", 120), ("mujoco", 120), ("pybullet", 120)]
    + [(backend, None) for backend in ("coppeliasim", "vrep", "replay", "mock")],
)
def test_encoders_are_read_once_a_tick_if_a_read_is_slow(backend: str, rate_hz: float | None) -> None:
    assert load_backend(backend).encoder_rate_hz == rate_hz
