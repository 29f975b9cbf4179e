"""Runs the kit's rules directly, as pytest would, and tells which of them fail."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest

from drivers.kinematic.backend import KinematicBackend
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.testing import ConformanceSuite


class Sound(ConformanceSuite):
    """The suite on a backend that keeps every rule."""

    backend = KinematicBackend


@dataclass(frozen=True)
class Broken:
    """A fault that drivers have, the suite of a driver that has it, and the rules that must tell."""

    fault: str
    rules: frozenset[str]
    suite: type[ConformanceSuite]


def broken(
    fault: str,
    rules: str,
    damage: Callable[[Robot], Any] = lambda _: None,
    setup_for: Callable[[Setup], Setup] = lambda setup: setup,
) -> Broken:
    """Return a sound driver with one fault: a robot damaged after opening, or opened by a changed setup."""

    class Suite(Sound):
        def open(self, setup: Setup) -> Robot:
            robot = super().open(setup_for(setup))
            damage(robot)
            return robot

    return Broken(fault, frozenset(rules.split()), Suite)


def failing_rules(suite: type[ConformanceSuite]) -> set[str]:
    """Return the rules that fail. An error that is no failed expectation is passed on: a rule must not crash."""
    return {rule for rule in rule_names() if any(_fails(suite, rule, given) for given in _parameters(rule))}


def rule_names() -> set[str]:
    """Return every rule of the kit, without the ``test_``."""
    return {name.removeprefix("test_") for name in dir(ConformanceSuite) if name.startswith("test_")}


def swap_in(owner: object, name: str, replacement: Any) -> None:
    """Put something else in the place of an attribute or a method of this one object."""
    setattr(owner, name, replacement)


def _fails(suite: type[ConformanceSuite], rule: str, given: dict[str, Any]) -> bool:
    try:
        getattr(suite(), f"test_{rule}")(**given)
    except pytest.skip.Exception:
        return False
    except (AssertionError, pytest.fail.Exception):
        return True
    return False


def _parameters(rule: str) -> Iterator[dict[str, Any]]:
    marks = getattr(getattr(ConformanceSuite, f"test_{rule}"), "pytestmark", [])
    parametrised = [mark.args for mark in marks if mark.name == "parametrize"]
    if not parametrised:
        yield {}
    for name, values in parametrised:
        yield from ({name: value} for value in values)
