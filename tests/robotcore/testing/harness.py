"""Run the rules of the conformance kit directly, and return which of them fail."""

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
    """The suite on a backend that passes every rule."""

    backend = KinematicBackend


@dataclass(frozen=True)
class Broken:
    """A driver with a fault."""

    fault: str
    """The fault in words."""

    rules: frozenset[str]
    """The rules that must fail."""

    suite: type[ConformanceSuite]
    """The suite on the driver with the fault."""


def broken(
    fault: str,
    rules: str,
    damage: Callable[[Robot], Any] = lambda _: None,
    change_setup: Callable[[Setup], Setup] = lambda setup: setup,
) -> Broken:
    """Return a sound driver with one fault.

    fault: the fault in words.
    rules: the names of the rules that must fail, separated by spaces.
    damage: changes the opened robot.
    change_setup: changes the set-up before the opening.
    """

    class Suite(Sound):
        def open(self, setup: Setup) -> Robot:
            robot = super().open(change_setup(setup))
            damage(robot)
            return robot

    return Broken(fault, frozenset(rules.split()), Suite)


def failing_rules(suite: type[ConformanceSuite]) -> set[str]:
    """Return the rules that fail. Raises any exception that is no failed assertion, since a rule must not crash."""
    return {rule for rule in rule_names() if any(_fails(suite, rule, given) for given in _parameters(rule))}


def rule_names() -> set[str]:
    """Return the name of every rule, without ``test_``."""
    return {name.removeprefix("test_") for name in dir(ConformanceSuite) if name.startswith("test_")}


def swap_in(owner: object, name: str, replacement: Any) -> None:
    """Replace an attribute or a method of one object."""
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
