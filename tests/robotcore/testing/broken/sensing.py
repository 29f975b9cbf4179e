"""Functions that change the samples, the descriptions and the attributes of devices."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from tests.robotcore.testing.harness import replace_attribute

Damage = Callable[[Robot], None]


def change_samples(kind: type[Any], change: Callable[[Any], Any]) -> Damage:
    """Return a damage that changes every sample of the sensors of one kind."""

    def damage(robot: Robot) -> None:
        for device in robot.devices.values():
            if isinstance(device, kind):
                replace_attribute(device, "_newest", _chained(device._newest, change))

    return damage


def _chained(newest: Callable[[], Any], change: Callable[[Any], Any]) -> Callable[[], Any]:
    return lambda: change(newest())


def change_description(name: str, **changes: float) -> Callable[[Setup], Setup]:
    """Return a change of the setup that changes the description of a device."""

    def change_setup(setup: Setup) -> Setup:
        devices = tuple(d.model_copy(update=changes) if d.name == name else d for d in setup.robot.devices)
        robot = setup.robot.model_copy(update={"devices": devices})
        return replace(setup, robot=robot)

    return change_setup


def set_attributes(name: str, **values: Any) -> Damage:
    """Return a damage that sets attributes of a device."""

    def damage(robot: Robot) -> None:
        if name in robot.devices:
            for attribute, value in values.items():
                replace_attribute(robot[name], attribute, value)

    return damage
