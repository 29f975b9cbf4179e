"""Broken devices of kinds that have no rules of their own in the kit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from robotcore.hal.device import Actuator
from robotcore.hal.robot import Robot
from robotcore.kinds.bumper import Bumper
from tests.robotcore.testing.broken.sensing import change_samples
from tests.robotcore.testing.harness import Sound, broken, replace_attribute
from tests.robotcore.testing.variant_suites import EquippedBench


class EquippedSuite(EquippedBench, Sound):
    """The suite on a robot with devices of all kinds."""


def accept_any_command(name: str) -> Callable[[Robot], None]:
    return partial(_replace, name, "_limit", lambda _actuator, command: command)


def send_at_a_stop(name: str, *commands: Any) -> Callable[[Robot], None]:
    def stop(actuator: Actuator[Any]) -> None:
        for command in commands:
            actuator._apply(command)

    return partial(_replace, name, "stop", stop)


def _replace(name: str, hook: str, function: Callable[..., Any], robot: Robot) -> None:
    if name in robot.devices:
        replace_attribute(robot[name], hook, partial(function, robot[name]))


TYPES, RULES = "values_have_the_types_of_the_sample", "devices_follow_the_rules_of_their_kinds"
STOP = "stop_and_closing_send_only_the_safe_command"
BROKEN = (
    broken(
        "a bumper returns a number",
        TYPES,
        change_samples(Bumper, lambda sample: replace(sample, is_pressed=int(sample.is_pressed))),
        suite=EquippedSuite,
    ),
    broken("a light accepts nan", RULES, accept_any_command("lamp"), suite=EquippedSuite),
    broken("a buzzer accepts nan", RULES, accept_any_command("horn"), suite=EquippedSuite),
    broken("a servo accepts nan", RULES, accept_any_command("pan"), suite=EquippedSuite),
    broken("a servo turns at a stop", STOP, send_at_a_stop("pan", 0.0), suite=EquippedSuite),
    broken("a buzzer plays on after a stop", STOP, send_at_a_stop("horn"), suite=EquippedSuite),
)
