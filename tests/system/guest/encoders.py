from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, cast

import pytest

from robotcore.devices import Encoder
from tests.system.guest.bench import open_device
from tests.system.guest.chip import Chip
from tests.system.guest.waiting import settled
from tests.system.guest.wheel import Disc

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


def test_every_edge_forward_is_counted(disc: Disc, encoder: Encoder) -> None:
    disc.turn(40)
    assert settled(lambda: edges(encoder), 40) == 40


def test_every_edge_backward_is_counted_down(disc: Disc, encoder: Encoder) -> None:
    disc.turn(-40)
    assert settled(lambda: edges(encoder), -40) == -40


def test_a_wheel_that_shakes_on_an_edge_goes_nowhere(disc: Disc, encoder: Encoder) -> None:
    disc.turn(1)
    for _ in range(20):
        disc.turn(1)
        disc.turn(-1)
    assert settled(lambda: edges(encoder), 1) == 1
