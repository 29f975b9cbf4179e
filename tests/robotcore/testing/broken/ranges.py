from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, ClassVar

from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.kinds.range_sensor import Range, RangeSensor
from robotcore.testing import ConformanceSuite, TestSupport
from robotcore.testing.mock.backend import MockBackend
from robotcore.testing.mock.devices import LOST
from tests.robotcore.testing.broken.sensing import Damage, change_description, change_samples, set_attributes
from tests.robotcore.testing.harness import broken

MIN_RANGE, MAX_RANGE, CONE = 0.02, 2.0, 0.5236


def change_distances(change: Callable[[float], float]) -> Damage:
    return change_samples(RangeSensor, lambda sample: replace(sample, distance=change(sample.distance)))


def mirror(sample: Range) -> Range:
    if sample.point is None:
        return sample
    x, y, z = sample.point
    return replace(sample, point=(x, -y, z))


class EchoLossSuite(ConformanceSuite):
    """A suite that can suppress echoes. The sensor then returns the reading ``instead``."""

    backend = MockBackend
    lacks: ClassVar = {TestSupport.WORLD: "its sensors follow a script"}
    instead: ClassVar[Any] = LOST
    is_lost = False

    def open(self, setup: Setup) -> Robot:
        return MockBackend({"nose": lambda _: self.instead if self.is_lost else 1.0}).open(setup)

    def lose_echoes(self, robot: Robot) -> None:
        self.is_lost = True


class InfiniteEchoLossSuite(EchoLossSuite):
    instead = math.inf


class NewEchoLossSuite(EchoLossSuite):
    instead = 1.0


BROKEN = (
    broken(
        "distances are 15 mm too long",
        "distance_to_a_wall_is_right",
        change_distances(lambda metres: metres + 0.015 if metres > 0.1 else metres),
    ),
    broken(
        "nothing in range reads the maximum",
        "nothing_ahead_reads_inf beyond_the_maximum_reads_inf cone_is_the_full_angle",
        change_distances(lambda metres: min(metres, MAX_RANGE)),
    ),
    broken(
        "it reads beyond its maximum",
        "beyond_the_maximum_reads_inf",
        set_attributes("nose", max_range=MAX_RANGE),
        change_description("nose", max_range_m=MAX_RANGE + 1),
    ),
    broken(
        "it reads below its minimum",
        "nearer_than_the_minimum_reads_the_minimum",
        set_attributes("nose", min_range=MIN_RANGE),
        change_description("nose", min_range_m=MIN_RANGE / 10),
    ),
    broken(
        "rays begin behind an obstacle that touches the robot",
        "touching_a_wall_does_not_read_inf nearer_than_the_minimum_reads_the_minimum",
        change_distances(lambda metres: math.inf if metres <= MIN_RANGE else metres),
    ),
    broken(
        "the cone is twice as wide as described",
        "cone_is_the_full_angle",
        set_attributes("nose", cone=CONE),
        change_description("nose", cone_rad=2 * CONE),
    ),
    broken(
        "the cone is a single beam",
        "cone_is_the_full_angle",
        set_attributes("nose", cone=CONE),
        change_description("nose", cone_rad=0.0),
    ),
    broken("the detected point is mirrored", "detected_point_is_left_positive", change_samples(RangeSensor, mirror)),
    broken("the cone is half the described one", "limits_equal_the_description", set_attributes("nose", cone=CONE / 2)),
    broken(
        "distances that are too long are returned",
        "distance_is_within_the_limits_or_inf",
        change_distances(lambda metres: MAX_RANGE + metres),
        suite=EchoLossSuite,
    ),
    broken(
        "distances that cannot be measured are nan",
        "distance_is_within_the_limits_or_inf",
        change_distances(lambda _: math.nan),
        suite=EchoLossSuite,
    ),
    broken("a lost echo reads inf", "lost_echo_makes_no_new_sample", suite=InfiniteEchoLossSuite),
    broken("a lost echo reads the old value as new", "lost_echo_makes_no_new_sample", suite=NewEchoLossSuite),
)
