"""What the checks share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.system.firmware.backend import switched_on
from tests.system.firmware.board import Board


@pytest.fixture
def board() -> Iterator[Board]:
    """A board that runs our firmware."""
    with switched_on() as made:
        yield made
