"""Fixtures of the checks."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.system.firmware.backend import switched_on
from tests.system.firmware.board import Board


@pytest.fixture
def board() -> Iterator[Board]:
    """A board with robotcore_bridge."""
    with switched_on() as made:
        yield made
