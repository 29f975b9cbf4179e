from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, cast

import pytest

from robotcore.hal.devices import Encoder
from tests.system.guest.bench import open_device, settled
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


def pluralize(encoder: Encoder, disc: Disc, way: Iterable[int]) -> list[int]:
    """Turn the disc edge by edge, each heard before the next: bursts would be a matter of timing."""
    return [settled(lambda: edges(encoder), disc.turn(edge)) for edge in way]


def test_every_edge_forward_counts_up(disc: Disc, encoder: Encoder) -> None:
    assert pluralize(encoder, disc, [1] * 40) == list(range(1, 41))


def test_every_edge_backward_counts_down(disc: Disc, encoder: Encoder) -> None:
    assert pluralize(encoder, disc, [-1] * 40) == list(range(-1, -41, -1))


def test_a_wheel_that_shakes_on_an_edge_goes_nowhere(disc: Disc, encoder: Encoder) -> None:
    assert pluralize(encoder, disc, [1, -1] * 20) == [1, 0] * 20
