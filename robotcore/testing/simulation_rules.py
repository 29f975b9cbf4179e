"""Rules for simulators: the true pose, twist and contacts, and the equality of equal runs."""

from __future__ import annotations

import math
from typing import Any

import pytest

from robotcore.description import Mount, Start, WorldDescription
from robotcore.geometry import Pose, Wheels, wrap_angle
from robotcore.hal.backend import Capability
from robotcore.hal.robot import Robot, Role
from robotcore.hal.truth import TruthSource
from robotcore.kinds.camera import CameraDescription, Frame
from robotcore.testing import worlds
from robotcore.testing.bench import NO_TRUTH, RATE_HZ, TestBench, TestSupport, compute_motion, list_sensors

ARC = (3.0, 5.0)
"""The left and the right wheel velocity of a left turn, in rad/s."""

WIDE_ARC = (3.5, 4.5)
"""Those of a robot that cannot turn on the spot."""

SPIN_RAD_S = 4.0
"""The velocity of the wheels in a turn on the spot, in rad/s."""

SPIN_RAD = 1.25 * math.pi
"""The angle of a turn on the spot, in radians. It exceeds π, also if the wheels lag."""


class TruthRules(TestBench):
    """Rules for the ground truth of a simulator with `Capability.POSE` or `Capability.CONTACTS`."""

    def test_pose_begins_at_the_start(self) -> None:
        self.require(Capability.POSE, TestSupport.WORLD)
        start = Start(x_m=0.5, y_m=-0.3, yaw_rad=0.7)
        with self.open_robot(worlds.empty(start), Role.DRIVE) as robot:
            x, y, heading = _require_truth(robot).pose()
        assert (x, y, wrap_angle(heading)) == pytest.approx(start.pose, abs=0.005), (
            f"the true pose is {(x, y, heading)} at the start. Return the start of the world, {start.pose}, as the "
            "pose of the axle's centre"
        )

    def test_true_heading_is_between_minus_pi_and_pi(self) -> None:
        self.require(Capability.POSE, TestSupport.MOTION)
        wheels = self._choose_sharpest_turn()
        turn_rate = self.drive.geometry.to_twist(wheels).angular
        with self.open_robot(None, Role.DRIVE) as robot:
            self.command_wheels(robot, *wheels, seconds=SPIN_RAD / turn_rate)
            heading = _require_truth(robot).pose().heading
        assert abs(heading) <= math.pi, (
            f"the heading of the true pose is {heading:.2f} rad after a left turn of {SPIN_RAD:.2f} rad from 0. "
            "Return a heading from -π to π, such as wrap_angle(heading)"
        )

    def test_pose_moves_as_the_wheels_roll(self) -> None:
        self.require(TestSupport.MOTION)
        with self.open_robot(None, Role.DRIVE) as robot:
            pose, angles = self.read_pose(robot), self._angles(robot)
            self.command_wheels(robot, *self._choose_arc(), seconds=1.5)
            self.command_wheels(robot, 0.0, 0.0)  # a polled encoder of a wheel at rest is not late
            left, right = (now - then for now, then in zip(self._angles(robot), angles, strict=True))
            motion = compute_motion(pose, self.read_pose(robot))
        rolled = self.drive.geometry.to_twist(Wheels(left, right))
        origin = Pose(0.0, 0.0, 0.0)
        expected = compute_motion(origin, origin.advance(*rolled))
        assert tuple(motion) == pytest.approx(tuple(expected), abs=0.02), (
            f"the pose moved by {motion}, and the encoders' angles give {expected}. Use the described wheel "
            "radius and track, and check that the wheels do not slip"
        )

    def test_twist_is_the_change_of_the_pose(self) -> None:
        self.require(Capability.POSE, TestSupport.MOTION)
        with self.open_robot(None, Role.DRIVE) as robot:
            self.command_wheels(robot, *self._choose_arc())
            twist = _require_truth(robot).twist()
            motion = self.measure_motion(robot, 0.1)
        change = (motion.forward / 0.1, motion.turn / 0.1)
        assert tuple(twist) == pytest.approx(change, rel=0.05, abs=0.01), (
            f"the true twist is {twist}, and the true pose changes by {change[0]:.3f} m/s and {change[1]:.3f} rad/s. "
            "Return the twist of the axle's centre in m/s and rad/s"
        )

    def test_open_ground_causes_no_contact(self) -> None:
        self.require(Capability.CONTACTS, TestSupport.MOTION)
        with self.open_robot(None, Role.DRIVE) as robot:
            self.command_wheels(robot, 4.0, 4.0, seconds=1.0)
            contacts = _require_truth(robot).contacts()
        assert contacts == 0, (
            f"the simulator counted {contacts} contacts on open ground. Do not count contacts with the floor"
        )

    def test_bump_into_a_wall_is_one_contact(self) -> None:
        self.require(Capability.CONTACTS, TestSupport.MOTION, TestSupport.WORLD)
        with self.open_robot(self._wall_close_ahead(), Role.DRIVE) as robot:
            self.command_wheels(robot, 4.0, 4.0, seconds=2.0)
            contacts = _require_truth(robot).contacts()
        assert contacts == 1, (
            f"the simulator counted {contacts} contacts of a robot that drove against a wall. "
            "Count a contact once until it ends"
        )

    def _choose_arc(self) -> tuple[float, float]:
        return WIDE_ARC if self.description.min_turn_radius_m else ARC

    def _choose_sharpest_turn(self) -> Wheels:
        """Return the wheel velocities, in rad/s, of a turn on the spot, or of the sharpest turn to the left."""
        if not (radius := self.description.min_turn_radius_m):
            return Wheels(-SPIN_RAD_S, SPIN_RAD_S)
        speed = SPIN_RAD_S * self.drive.wheel_radius_m
        return self.drive.geometry.to_wheels(speed, speed / radius)

    def _angles(self, robot: Robot) -> Wheels:
        left, right = self.get_encoders(robot)
        return Wheels(left.read().angle, right.read().angle)

    def _wall_close_ahead(self) -> WorldDescription:
        nose = Mount(x_m=self.description.body.front_x_m, z_m=self.description.body.height_m)
        return worlds.wall(nose, 0.1)


def _require_truth(robot: Robot) -> TruthSource:
    assert robot.truth is not None, NO_TRUTH
    return robot.truth


TICKS = 10


class RepeatRules(TestBench):
    """Rules for a simulator with `Capability.LOCKSTEP`."""

    def test_equal_runs_read_equal_samples(self) -> None:
        self.require(Capability.LOCKSTEP, TestSupport.REPRODUCIBLE)
        first, second = self._read_samples(), self._read_samples()
        differing = [name for name in first if first[name] != second[name]]
        assert not differing, (
            f"two runs with equal commands differ in {', '.join(differing)}. Remove the machine's time, threads, "
            "random numbers without the run's seed, and state that outlives close()"
        )

    def _read_samples(self) -> dict[str, list[Any]]:
        """Make a short run, and return the samples of each sensor, and the true poses, by name."""
        samples: dict[str, list[Any]] = {}
        with self.open_robot(self._world()) as robot:
            for tick in range(1, TICKS + 1):
                self._steer(robot, tick)
                robot.clock.sleep_until(tick / RATE_HZ)
                for sensor in list_sensors(robot):
                    samples.setdefault(sensor.name, []).append(_to_comparable(sensor.read()))
                if robot.truth:
                    samples.setdefault("the true pose", []).append(robot.truth.pose())
        return samples

    def _world(self) -> WorldDescription | None:
        eye = self.description.first_of(CameraDescription)
        return worlds.ball(eye.mount, 0.9, 0.2) if eye else None

    def _steer(self, robot: Robot, tick: int) -> None:
        if self.description.drive:
            self.command_wheels(robot, 1.0 + 0.3 * tick, 4.0 - 0.2 * tick, seconds=0.0)


def _to_comparable(sample: Any) -> Any:
    """Return a sample as a value that supports ``==``, which a sample with an array does not."""
    return (sample.time, sample.image.tobytes()) if isinstance(sample, Frame) else sample
