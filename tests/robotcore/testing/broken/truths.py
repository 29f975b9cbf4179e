from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from robotcore.description import Start
from robotcore.geometry import Twist
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.kinds.encoder import Encoder
from tests.robotcore.testing.broken.sensing import change_samples
from tests.robotcore.testing.harness import broken, replace_attribute

_NUMBERS = itertools.count()


def change_truth(name: str, change: Callable[[Any], Any]) -> Callable[[Robot], None]:
    """Return a damage that changes one value of the ground truth."""

    def damage(robot: Robot) -> None:
        read = getattr(robot.truth, name)
        replace_attribute(robot.truth, name, lambda: change(read()))

    return damage


def start_at_the_origin(setup: Setup) -> Setup:
    assert setup.world
    return replace(setup, world=setup.world.model_copy(update={"start": Start()}))


def narrow_the_track(setup: Setup) -> Setup:
    if setup.robot.drive is None:
        return setup
    drive = setup.robot.drive.model_copy(update={"track_m": 0.1})
    return replace(setup, robot=setup.robot.model_copy(update={"drive": drive}))


def keep_state_between_runs(robot: Robot) -> None:
    change_samples(Encoder, lambda sample: replace(sample, angle=sample.angle + 1e-12 * next(_NUMBERS)))(robot)


BROKEN = (
    broken("the start of the world is ignored", "pose_begins_at_the_start", change_setup=start_at_the_origin),
    broken(
        "the true heading is from 0 to 2π",
        "true_heading_is_between_minus_pi_and_pi",
        change_truth("pose", lambda pose: pose._replace(heading=pose.heading % math.tau)),
    ),
    broken("the track is not the described one", "pose_moves_as_the_wheels_roll", change_setup=narrow_the_track),
    broken(
        "the twist is that of one wheel",
        "twist_is_the_change_of_the_pose",
        change_truth("twist", lambda twist: Twist(2 * twist.linear, twist.angular)),
    ),
    broken(
        "the floor is a contact", "open_ground_causes_no_contact", change_truth("contacts", lambda count: max(count, 1))
    ),
    broken(
        "each instant of a touch is a contact",
        "bump_into_a_wall_is_one_contact",
        change_truth("contacts", lambda n: 9 * n),
    ),
    broken("state outlives the run", "equal_runs_read_equal_samples", keep_state_between_runs),
)
