from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, cast

import pytest

from robotcore.kinds.encoder import Encoder
from tests.system.guest.bench import open_device, wait_until
from tests.system.guest.chip import Chip
from tests.system.guest.models import Disc

A, B = 5, 6
EDGES_PER_TURN = 20


@pytest.fixture
def disc(chip: Chip) -> Disc:
    return Disc(chip, A, B)


@pytest.fixture
def encoder(disc: Disc, pins: Any) -> Iterator[Encoder]:
    opened = cast("Encoder", open_device("left_encoder", pins))
    yield opened
    opened.close()


def edges(encoder: Encoder) -> int:
    return round(encoder.read().angle / math.tau * EDGES_PER_TURN)


def turn(encoder: Encoder, disc: Disc, steps: Iterable[int]) -> list[int]:
    """Turn the disc edge by edge, and return the count after each. Bursts of edges could be lost here."""
    return [wait_until(lambda: edges(encoder), disc.turn(step)) for step in steps]


def test_every_edge_forward_counts_up(disc: Disc, encoder: Encoder) -> None:
    assert turn(encoder, disc, [1] * 40) == list(range(1, 41))


def test_every_edge_backward_counts_down(disc: Disc, encoder: Encoder) -> None:
    assert turn(encoder, disc, [-1] * 40) == list(range(-1, -41, -1))


def test_a_wheel_that_trembles_at_an_edge_does_not_drift(disc: Disc, encoder: Encoder) -> None:
    assert turn(encoder, disc, [1, -1] * 20) == [1, 0] * 20
