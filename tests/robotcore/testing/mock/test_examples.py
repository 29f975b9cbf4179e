from __future__ import annotations

import doctest

from robotcore.testing.mock import robot


def test_examples_in_docstrings_run() -> None:
    assert doctest.testmod(robot).failed == 0
    assert doctest.testmod(robot).attempted > 0
