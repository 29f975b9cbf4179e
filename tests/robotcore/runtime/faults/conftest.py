"""Fixtures of the tests of faults."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import EntryPoint

import pytest

from robotcore import plugins

Register = Callable[..., None]
Wheels = dict[str, float]


@pytest.fixture
def register(monkeypatch: pytest.MonkeyPatch) -> Register:
    """Return a function that adds an entry point with a name and a value to the installed ones, by default a fault."""

    def add(name: str, value: str, group: str = plugins.FAULTS) -> None:
        groups = (plugins.APPS, plugins.BACKENDS, plugins.FAULTS, plugins.KINDS)
        points = {each: dict(plugins._points(each)) for each in groups}
        points[group][name] = EntryPoint(name, value, group)
        monkeypatch.setattr("robotcore.plugins._points", points.get)

    return add


@pytest.fixture
def wheels(monkeypatch: pytest.MonkeyPatch) -> Wheels:
    """Return the last command of each motor of the kinematic simulator, in rad/s."""
    from drivers.kinematic.devices import KinematicMotor

    commands: Wheels = {}
    apply = KinematicMotor._apply

    def log_command(motor: KinematicMotor, rad_s: float) -> None:
        commands[motor.name] = rad_s
        apply(motor, rad_s)

    monkeypatch.setattr(KinematicMotor, "_apply", log_command)
    return commands
