"""Changes to the samples of sensors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from tests.robotcore.testing.harness import swap_in

Damage = Callable[[Robot], None]


def change_samples(kind: type[Any], change: Callable[[Any], Any]) -> Damage:
    """Change every sample of the sensors of one kind."""

    def damage(robot: Robot) -> None:
        for device in robot.devices.values():
            if isinstance(device, kind):
                swap_in(device, "_newest", _chained(device._newest, change))

    return damage


def _chained(newest: Callable[[], Any], change: Callable[[Any], Any]) -> Callable[[], Any]:
    return lambda: change(newest())


def change_description(name: str, **changes: float) -> Callable[[Setup], Setup]:
    """Open a device by a description that differs from the one of the suite."""

    def change_setup(setup: Setup) -> Setup:
        devices = tuple(d.model_copy(update=changes) if d.name == name else d for d in setup.robot.devices)
        robot = setup.robot.model_copy(update={"devices": devices})
        return replace(setup, robot=robot)

    return change_setup


def set_attributes(name: str, **values: Any) -> Damage:
    """Set attributes of a device if it is open."""

    def damage(robot: Robot) -> None:
        if name in robot.devices:
            for attribute, value in values.items():
                swap_in(robot[name], attribute, value)

    return damage
