"""Broken devices of kinds that have no rules of their own in the kit."""

from __future__ import annotations

from dataclasses import replace

from robotcore.description import Mount, RobotDescription
from robotcore.hal.robot import Robot
from robotcore.kinds.bumper import Bumper, BumperDescription
from robotcore.kinds.led import Brightness, LedDescription
from robotcore.kinds.line_sensor import LineSensorDescription
from tests.robotcore.testing.broken.devices import ROVER
from tests.robotcore.testing.broken.sensing import change_samples
from tests.robotcore.testing.harness import Sound, broken, replace_attribute

ROW = LineSensorDescription(kind="line_sensor", name="row", mount=Mount(x_m=0.1, z_m=0.01), count=3, spacing_m=0.01)
FRONT, LAMP = BumperDescription(kind="bumper", name="front"), LedDescription(kind="led", name="lamp")


class EquippedSuite(Sound):
    """The suite on a robot with a bumper, a light and a line sensor."""

    @property
    def description(self) -> RobotDescription:
        return ROVER.model_copy(update={"devices": (*ROVER.devices, FRONT, LAMP, ROW)})


def accept_any_brightness(robot: Robot) -> None:
    def limit(command: Brightness) -> Brightness:
        return command

    if "lamp" in robot.devices:
        replace_attribute(robot["lamp"], "_limit", limit)


TYPES, RULES = "values_have_the_types_of_the_sample", "devices_follow_the_rules_of_their_kinds"
BROKEN = (
    broken(
        "a bumper returns a number",
        TYPES,
        change_samples(Bumper, lambda sample: replace(sample, is_pressed=int(sample.is_pressed))),
        suite=EquippedSuite,
    ),
    broken("a light accepts nan", RULES, accept_any_brightness, suite=EquippedSuite),
)
