"""Broken displays, batteries and encoders."""

from __future__ import annotations

import math
from dataclasses import replace

from robotcore.description import RobotDescription, load_robot
from robotcore.hal.robot import Robot
from robotcore.kinds.battery import Battery, BatteryDescription, Voltage
from robotcore.kinds.encoder import Encoder
from robotcore.optics import Image
from tests.doubles.battery_backend import BatteryBackend
from tests.robotcore.testing.broken.sensing import Damage, change_samples
from tests.robotcore.testing.harness import Sound, broken, replace_attribute


def refuse_grey(robot: Robot) -> None:
    def show(image: Image) -> None:
        _, _, _ = image.shape

    if "screen" in robot.devices:
        replace_attribute(robot["screen"], "_apply", show)


def draw_a_frame(robot: Robot) -> None:
    def show(image: Image) -> None:
        if image.flags.writeable:
            image[0] = 0

    if "screen" in robot.devices:
        replace_attribute(robot["screen"], "_apply", show)


ROVER = load_robot("rover")
POWERED = ROVER.model_copy(update={"devices": (*ROVER.devices, BatteryDescription(kind="battery", name="cells"))})


class BatterySuite(Sound):
    """The suite on a robot with a battery."""

    backend = BatteryBackend

    @property
    def description(self) -> RobotDescription:
        return POWERED


def scale_angles(factor: float, offset: float = 0.0) -> Damage:
    return change_samples(Encoder, lambda sample: replace(sample, angle=factor * sample.angle + offset))


def swap_encoders(robot: Robot) -> None:
    encoders = [device for device in robot.devices.values() if isinstance(device, Encoder)]
    if len(encoders) == 2:
        left, right = encoders
        left_newest, right_newest = left._newest, right._newest
        replace_attribute(left, "_newest", right_newest)
        replace_attribute(right, "_newest", left_newest)


BROKEN = (
    broken("the display refuses grey pictures", "display_accepts_a_read_only_picture", refuse_grey),
    broken("the display draws on the app's picture", "display_does_not_change_the_picture", draw_a_frame),
    broken(
        "a battery that cannot be read has zero volts",
        "devices_follow_the_rules_of_their_kinds",
        change_samples(Battery, lambda sample: replace(sample, voltage=0.0)),
        suite=BatterySuite,
    ),
    broken(
        "a battery that cannot be read has nan volts",
        "devices_follow_the_rules_of_their_kinds",
        change_samples(Battery, lambda sample: replace(sample, voltage=math.nan)),
        suite=BatterySuite,
    ),
    broken(
        "a battery is measured once",
        "capture_time_advances",
        change_samples(Battery, lambda _: Voltage(7.4, 0.0, 0)),
        suite=BatterySuite,
    ),
    broken("angles do not count from the opening", "encoders_begin_at_zero", scale_angles(1.0, 7.0)),
    broken(
        "encoders count backwards",
        "encoders_count_forward_as_positive pose_moves_as_the_wheels_roll",
        scale_angles(-1.0),
    ),
    broken(
        "encoders have no direction",
        "encoders_count_forward_as_positive",
        change_samples(Encoder, lambda sample: replace(sample, angle=abs(sample.angle))),
    ),
    broken(
        "angles are in degrees",
        "angles_are_in_radians pose_moves_as_the_wheels_roll",
        scale_angles(math.degrees(1.0)),
    ),
    broken(
        "angles wrap at a whole turn",
        "angles_count_beyond_a_turn pose_moves_as_the_wheels_roll",
        change_samples(Encoder, lambda sample: replace(sample, angle=sample.angle % math.tau)),
    ),
    broken(
        "left and right encoder are swapped",
        "each_encoder_counts_its_own_wheel pose_moves_as_the_wheels_roll",
        swap_encoders,
    ),
)
