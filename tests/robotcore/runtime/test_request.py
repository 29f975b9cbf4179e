"""The types of the values of a request, and apps that are given as a class or an instance."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from robotcore.errors import UsageError
from robotcore.hal.robot import Robot, Role
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.session import RunRequest, run
from robotcore.sweep import Sweep
from tests.texts import Raises


@dataclass
class Waiter(Behaviour):
    wait_ticks: int = 3

    needs = frozenset({Role.DRIVE})

    def __post_init__(self) -> None:
        self.ticks = 0

    def step(self, robot: Robot) -> Status:
        self.ticks += 1
        return Status.SUCCESS if self.ticks == self.wait_ticks else Status.RUNNING


def test_a_class_is_run_with_its_settings() -> None:
    result = run(RunRequest(Waiter, settings={"wait_ticks": "5"}))
    assert (result.app, result.ticks) == ("Waiter", 5)


def test_a_numpy_integer_is_a_seed() -> None:
    plain = run(RunRequest("green-search", seed=3, timeout_s=0.2))
    numpy = run(RunRequest("green-search", seed=np.int64(3), timeout_s=0.2))  # type: ignore[arg-type]
    assert (numpy.seed, numpy.trace_sha256) == (3, plain.trace_sha256)


def test_an_instance_is_run_as_it_is() -> None:
    app = Waiter(wait_ticks=4)
    result = run(RunRequest(app))
    assert (result.app, result.ticks, app.ticks) == ("Waiter", 4, 4)


def test_an_instance_has_no_settings(raises: Raises) -> None:
    with raises(UsageError, "settings-without-effect"):
        run(RunRequest(Waiter(), settings={"wait_ticks": 5}))


def test_a_sweep_needs_the_name_of_an_app(raises: Raises) -> None:
    with raises(UsageError, "app-not-named"):
        Sweep(RunRequest(Waiter))


@pytest.mark.parametrize(
    "field, value",
    [
        ("app", 5),
        ("app", dict),
        ("backend", None),
        ("robot", Path("mine.toml")),
        ("world", 5),
        ("seed", "a"),
        ("seed", 1.5),
        ("rate_hz", "20"),
        ("timeout_s", None),
        ("settings", ["speed_m_s"]),
        ("options", "port=7"),
        ("judge", 5),
        ("faults", "camera drop=0.2"),
        ("faults", (5,)),
    ],
)
def test_a_value_of_the_wrong_type_is_refused(field: str, value: object, raises: Raises) -> None:
    with raises(UsageError, "wrong-type", field=field, value=value):
        RunRequest(**{"app": "green-search", field: value})  # type: ignore[arg-type]
