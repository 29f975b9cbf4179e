"""The course of the wheels between two ticks, from polls, with faults, and with a servo that steers."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import pytest

from robotcore.description import RobotDescription
from robotcore.errors import DeviceError
from robotcore.geometry import DifferentialGeometry, Pose, Wheels
from robotcore.hal.clock import SteppedClock, TickClock
from robotcore.hal.drive import CommandIntegrator, Odometry, WheelPath
from robotcore.hal.joint import Joint
from robotcore.hal.robot import Robot
from robotcore.kinds.encoder import Angle, Encoder
from robotcore.runtime.faults import plan_faults
from robotcore.runtime.layers import AssembledRobot, assemble
from robotcore.runtime.layers.base import Tap
from robotcore.runtime.layers.encoder_polling import TimedAngles
from robotcore.runtime.layers.wheel_angles import (
    PolledAngles,
    PresentAngles,
    SteeredAngles,
    WheelPathReader,
    compute_present_angles,
)
from tests.robotcore.fakes import ROVER, NullMotor, NullRange
from tests.robotcore.runtime.layers.test_encoder_polling import Bench, TurningEncoder

GEOMETRY = DifferentialGeometry(wheel_radius=0.05, track=0.2)
EVEN = [Wheels(0.1 * step, 0.2 * step) for step in range(1, 5)]


class FixedEncoder(Encoder):
    """Returns the same sample at each read."""

    def __init__(self, name: str, sample: Angle) -> None:
        super().__init__(name)
        self._sample = sample

    def _newest(self) -> Angle:
        return self._sample


class PolledBench(Bench):
    """The bench with the angles of a tick, which a test may falsify as a fault does."""

    def __init__(self, late_s: float = 0.0) -> None:
        super().__init__(late_s=late_s)
        self.falsify: Callable[[Wheels], Wheels] = lambda angles: angles
        self.reads = [self.polling.sensor(encoder, encoder.read) for encoder in (self.left, self.right)]
        self.commanded = CommandIntegrator(self.clock)
        self.read_course = PolledAngles(self.read, self.polling, self.commanded, self.clock)

    def read(self) -> Wheels:
        left, right = (read() for read in self.reads)
        return self.falsify(compute_present_angles([left], [right], self.commanded))

    def tick(self) -> Sequence[TimedAngles]:
        self.layered.sleep_until(self.clock.now() + 0.05)
        return self.read_course()


def test_first_tick_has_only_the_present_angles() -> None:
    bench = PolledBench()
    assert len(bench.tick()) == 1
    assert len(bench.tick()) == 10


def test_course_between_two_ticks_is_that_of_the_polls() -> None:
    bench = PolledBench()
    bench.tick()
    course = bench.tick()
    assert [time for time, _ in course] == pytest.approx(
        [step / 240 for step in (13, 14, 16, 17, 18, 19, 20, 22, 23, 24)]
    )
    assert [angles for _, angles in course] == [pytest.approx((2 * time, time**2)) for time, _ in course]


def test_second_reading_in_a_tick_has_only_the_present_angles() -> None:
    bench = PolledBench()
    bench.tick()
    course = bench.tick()
    assert bench.read_course() == (course[-1],)
    assert len(bench.tick()) == 10


def test_rotation_is_that_of_the_ticks_and_the_polls_give_its_course() -> None:
    bench = PolledBench()
    bench.tick()
    before = bench.read()
    bench.falsify = lambda angles: Wheels(angles.left + 0.3, before.right)  # the right encoder has frozen
    course = bench.tick()
    start, end = course[0].time - 1 / 240, course[-1].time
    for time, angles in course:
        share = (time - start) / (end - start)
        bulge = time**2 - start**2 - share * (end**2 - start**2)
        assert angles == pytest.approx((2 * time + 0.3 * share, before.right + bulge))
    assert course[-1].angles == Wheels(2 * end + 0.3, before.right)


def test_angles_are_computed_again_only_for_new_samples() -> None:
    bench = PolledBench()
    read = PresentAngles([bench.left], [bench.right], bench.commanded, bench.clock)
    bench.clock.sleep_until(0.5)
    first = read()
    assert first == (1.0, 0.25)
    assert read() is first
    bench.clock.sleep_until(1.0)
    assert read() == (2.0, 1.0)


def test_angles_of_old_samples_grow_by_the_commanded_rotation() -> None:
    bench = PolledBench()
    left, right = bench.left.read(), bench.right.read()
    old = [FixedEncoder("left", left), FixedEncoder("right", right)]
    read = PresentAngles(old[:1], old[1:], bench.commanded, bench.clock)
    bench.commanded.turn_at(Wheels(1.0, 2.0), 0.0)
    assert read() == (0.0, 0.0)
    bench.clock.sleep_until(0.5)
    assert read() == (0.5, 1.0)


def test_further_reading_of_the_same_samples_has_the_same_course() -> None:
    bench = PolledBench()
    angles = PresentAngles([bench.left], [bench.right], bench.commanded, bench.clock)
    read_course = PolledAngles(angles, bench.polling, bench.commanded, bench.clock)
    bench.layered.sleep_until(0.05)
    read_course()
    bench.layered.sleep_until(0.1)
    course = read_course()
    assert read_course() == (course[-1],)


def test_course_goes_on_over_a_tick_without_angles() -> None:
    bench = PolledBench()
    bench.tick()
    bench.right.is_broken = True
    bench.layered.sleep_until(0.1)
    with pytest.raises(DeviceError):
        bench.read_course()
    bench.right.is_broken = False
    course = bench.tick()
    assert [round(240 * time) for time, _ in course] == [25, 26, 28, 29, 30, 31, 32, 34, 35, 36]
    assert course[-1].angles == pytest.approx((0.3, 0.15**2))


def test_samples_that_no_encoder_measured_have_no_course() -> None:
    bench = PolledBench()
    bench.reads[1] = bench.right.read  # the layer does not get its samples
    bench.tick()
    ((time, angles),) = bench.tick()
    assert time == 0.1
    assert angles == pytest.approx((0.2, 0.01))


def test_late_samples_are_corrected_by_the_commands() -> None:
    bench = PolledBench(late_s=0.02)
    bench.commanded.turn_at(Wheels(2.0, 0.0), 0.0)
    bench.layered.sleep_until(1.0)
    bench.tick()
    course = bench.tick()
    assert len(course) == 1 + 6  # without those from before the last tick
    for time, angles in course:
        assert angles.left == pytest.approx(2 * time)
    assert course[-1].angles.right == pytest.approx((1.1 - 0.02) ** 2)


def test_course_ends_at_samples_that_are_newer_than_the_begin_of_their_tick() -> None:
    bench = PolledBench()
    ticks = TickClock(bench.layered)
    bench.read_course = PolledAngles(bench.read, bench.polling, bench.commanded, ticks)
    courses = []
    for end in (0.05, 0.1, 0.15):
        ticks.sleep_until(end)
        bench.layered.sleep_until(end + 0.02)  # the tick has begun, but reads the encoders later
        bench.polling.sleep_until(bench.clock, end + 0.02)
        courses.append(bench.read_course())
    assert [course[-1].time for course in courses] == pytest.approx([0.07, 0.12, 0.17], abs=1 / 240)
    times = [time for course in courses for time, _ in course]
    assert times == sorted(set(times))


def test_steering_angle_between_two_ticks_counts() -> None:
    clock = SteppedClock(20, lambda _: None)
    joint = Joint(clock, 0.0, 4.0)
    times = [0.0125, 0.025, 0.0375, 0.05]
    read = SteeredAngles(lambda: [TimedAngles(time, Wheels(10 * time, 10 * time)) for time in times], joint, clock, 0.5)
    joint.turn_to(0.1)
    course = read()
    assert [time for time, _ in course] == times
    for time, (left, right) in course:
        # the tangent of an angle that grows by 4 rad/s up to 0.1 rad
        area = -math.log(math.cos(4 * min(time, 0.025))) / 4 + max(0.0, time - 0.025) * math.tan(0.1)
        assert (left, right) == pytest.approx((10 * time - 5 * area, 10 * time + 5 * area))


class TestWheelPath:
    def test_path_of_wheels_that_turn_evenly_is_one_arc(self) -> None:
        assert read_path(EVEN) == WheelPath(EVEN[-1])

    def test_path_of_wheels_whose_ratio_changes_has_the_angles_between(self) -> None:
        angles = [Wheels(0.0, 0.2), *EVEN[1:]]
        assert read_path(angles) == WheelPath(angles[-1], tuple(angles[:-1]))

    def test_path_within_the_error_of_the_encoders_is_one_arc(self) -> None:
        angles = [Wheels(0.08, 0.2), *EVEN[1:]]
        assert read_path(angles, count=0.01).between
        assert not read_path(angles, count=0.05).between

    def test_next_path_begins_at_the_end_of_the_last_one(self) -> None:
        courses = [EVEN, [Wheels(each.left + 0.4, each.right + 0.8) for each in EVEN]]
        read = WheelPathReader(lambda: [TimedAngles(0.0, angles) for angles in courses.pop(0)], GEOMETRY)
        assert read() == WheelPath(EVEN[-1])
        assert not read().between

    @pytest.mark.parametrize("bend", [0.002, 0.005, 0.01])
    def test_path_becomes_one_arc_if_the_pose_stays_within_ten_micrometres(self, bend: float) -> None:
        angles = [Wheels(each.left + bend * index * (3 - index), each.right) for index, each in enumerate(EVEN)]
        course = WheelPath(angles[-1], tuple(angles[:-1]))
        bent, straight = (Odometry(GEOMETRY, iter([path]).__next__).pose() for path in (course, WheelPath(angles[-1])))
        is_near = bent.distance_to(straight.x, straight.y) < 1e-5
        assert read_path(angles) == (WheelPath(angles[-1]) if is_near else course)


def read_path(angles: Sequence[Wheels], count: float = 0.0) -> WheelPath:
    return WheelPathReader(lambda: [TimedAngles(0.0, each) for each in angles], GEOMETRY, count)()


FAST = ROVER.model_copy(update={"drive": ROVER.drive.model_copy(update={"max_acceleration_rad_s2": None})})  # type: ignore[union-attr]
RATE = 10.0
"""The rate at which the wheels of the spinning rover reach their velocities, in 1/s."""


def open_rover(
    encoder_rate_hz: float | None,
    faults: Sequence[str] = (),
    description: RobotDescription = FAST,
    taps: Sequence[Tap] = (),
) -> AssembledRobot:
    """Open a rover that drives straight on, and then turns to the left ever faster."""
    clock = SteppedClock(10, lambda _: None)
    left = TurningEncoder("left_encoder", clock, lambda time: 8 * (1 - math.exp(-RATE * time)) / RATE)
    right = TurningEncoder("right_encoder", clock, lambda time: 8 * time)
    motors = NullMotor("left_motor"), NullMotor("right_motor")
    raw = Robot("rig", clock, [*motors, left, right, NullRange(clock)])
    planned = [fault.layer(clock, 1) for fault in plan_faults(faults, description, raw.devices)]
    return assemble(raw, description, 10, faults=planned, taps=taps, encoder_rate_hz=encoder_rate_hz)


def drive_rover(robot: AssembledRobot, seconds: float = 1.0) -> Pose:
    for tick in range(round(10 * seconds)):
        robot.robot.drive.track()
        robot.clock.sleep_until((tick + 1) / 10)
    return robot.robot.drive.pose


def integrate_pose(seconds: float = 1.0, steps: int = 10_000) -> Pose:
    """Return the pose of the rover by arcs of a tenth of a millisecond."""
    assert FAST.drive
    pose, geometry, step = Pose(0.0, 0.0, 0.0), FAST.drive.geometry, seconds / steps
    for index in range(steps):
        middle = (index + 0.5) * step
        twist = geometry.to_twist(Wheels(8 * math.exp(-RATE * middle), 8.0))
        pose = pose.advance(twist.linear * step, twist.angular * step)
    return pose


def compute_error(pose: Pose) -> float:
    true = integrate_pose()
    return pose.distance_to(true.x, true.y)


def test_polls_make_the_pose_exact_if_the_wheels_accelerate_within_ticks() -> None:
    one_arc, polled = compute_error(drive_rover(open_rover(None))), compute_error(drive_rover(open_rover(200.0)))
    assert one_arc > 3e-4
    assert polled < one_arc / 30


def test_polls_do_not_change_the_heading() -> None:
    headings = [drive_rover(open_rover(rate_hz)).heading for rate_hz in (None, 100.0, 200.0)]
    assert headings == [pytest.approx(headings[0], abs=1e-12)] * 3


def test_fault_of_an_encoder_changes_the_heading_with_polls_as_without() -> None:
    faults = ["left_encoder slip=0.5 after=0.2", "right_encoder freeze after=0.4 lasts=0.3"]
    without, polled = (drive_rover(open_rover(rate_hz, faults)) for rate_hz in (None, 200.0))
    assert polled.heading == pytest.approx(without.heading, abs=1e-12)
    assert polled.distance_to(without.x, without.y) < 0.01


class PathTap(Tap):
    """Counts the paths of the odometry with angles between two readings."""

    def __init__(self) -> None:
        self.bent = 0

    def wheel_path(self, read: Callable[[], WheelPath]) -> Callable[[], WheelPath]:
        def read_counted() -> WheelPath:
            path = read()
            self.bent += bool(path.between)
            return path

        return read_counted


@pytest.mark.parametrize("counts_per_turn, is_bent", [(960, True), (4, False)])
def test_counts_of_the_encoders_limit_the_paths(counts_per_turn: int, *, is_bent: bool) -> None:
    coarse = {"counts_per_turn": counts_per_turn}
    devices = [each.model_copy(update=coarse) if each.kind == "encoder" else each for each in FAST.devices]
    tap = PathTap()
    drive_rover(open_rover(200.0, description=FAST.model_copy(update={"devices": tuple(devices)}), taps=[tap]))
    assert bool(tap.bent) is is_bent


def test_each_encoder_has_one_sample_a_tick_with_polls() -> None:
    robot = open_rover(200.0)
    encoder = robot.robot["left_encoder"]
    assert isinstance(encoder, Encoder)
    drive_rover(robot, 0.2)
    assert encoder.read() is encoder.read()
    assert encoder.read().time == pytest.approx(0.2)
