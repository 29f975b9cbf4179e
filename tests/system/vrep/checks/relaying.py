"""Check that v1 shows the marked picture of v0 upright."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from robotcore.runtime.result import Outcome
from tests.system.vrep import scenes
from tests.system.vrep.server import run_on

YELLOW = (255, 255, 0)


@pytest.fixture(autouse=True)
def _build_relay() -> Iterator[None]:
    with scenes.relay():
        yield


def require_marked() -> None:
    """Check that the rectangle is on the lower left, where the ball is."""
    pixels = np.frombuffer(scenes.read_screen(), np.uint8).reshape(scenes.SIGHT_PX, scenes.SIGHT_PX, 3)
    rows, columns = np.nonzero((abs(pixels[::-1].astype(int) - YELLOW) < 60).all(axis=2))
    assert len(rows), "no rectangle"
    middle = scenes.SIGHT_PX / 2
    assert (rows.mean() > middle, columns.mean() < middle) == (True, True), (rows.mean(), columns.mean())


@pytest.mark.parametrize("stepped", [True, False])
def test_marked_picture_is_shown_upright_on_the_second_sensor(*, stepped: bool) -> None:
    with scenes.running():
        result = run_on("mark-green", more={"stepped": stepped})
        assert (result.outcome, "seen" in result.milestones) == (Outcome.SUCCESS, True), result.reason
        require_marked()


def test_marked_picture_stays_after_the_simulation_was_stopped() -> None:
    result = run_on("mark-green")
    assert (result.outcome, "seen" in result.milestones) == (Outcome.SUCCESS, True), result.reason
    require_marked()
