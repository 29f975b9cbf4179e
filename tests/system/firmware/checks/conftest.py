"""Fixtures of the checks."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.system.firmware.backend import start_board
from tests.system.firmware.board import Board


@pytest.fixture
def board() -> Iterator[Board]:
    """A board with robotcore_bridge."""
    with start_board() as made:
        yield made
