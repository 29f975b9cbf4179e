from __future__ import annotations

import pytest

from robotcore.errors import UsageError
from tests.robotcore.testing.harness import Sound


def test_suite_of_a_missing_robot_fails() -> None:
    suite = type("Mine", (Sound,), {"robot": "missing.toml"})
    with pytest.raises(UsageError):
        suite().test_steps_divide_the_tick(50.0)
