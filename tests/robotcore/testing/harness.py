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
    """The conformance suite on a backend that passes every rule."""

    backend = KinematicBackend


@dataclass(frozen=True)
class Broken:
    """A driver that violates rules on purpose."""

    problem: str
    """The driver's mistake."""

    rules: frozenset[str]
    """The rules that must fail."""

    suite: type[ConformanceSuite]
    """The conformance suite on the driver."""


def broken(
    problem: str,
    rules: str,
    damage: Callable[[Robot], Any] = lambda _: None,
    change_setup: Callable[[Setup], Setup] = lambda setup: setup,
    suite: type[ConformanceSuite] = Sound,
) -> Broken:
    """Return a driver that was changed to do one thing wrong.

    problem: what it does wrong.
    rules: the names of the rules that must fail, separated by spaces.
    damage: changes the open robot.
    change_setup: changes the setup before the robot is opened.
    suite: the conformance suite on the driver before it is changed.
    """

    def open_damaged(bench: ConformanceSuite, setup: Setup) -> Robot:
        robot = suite.open(bench, change_setup(setup))
        damage(robot)
        return robot

    return Broken(problem, frozenset(rules.split()), type("Suite", (suite,), {"open": open_damaged}))


def find_failing_rules(suite: type[ConformanceSuite]) -> set[str]:
    """Return the names of the rules that fail. An exception other than a failed assertion is raised."""
    return {rule for rule in list_rules() if any(_fails(suite, rule, given) for given in _parameters(rule))}


def list_rules() -> set[str]:
    """Return the names of all rules, without ``test_``."""
    return {name.removeprefix("test_") for name in dir(ConformanceSuite) if name.startswith("test_")}


def replace_attribute(owner: object, name: str, replacement: Any) -> None:
    """Replace an attribute or a method of an object."""
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
