"""What v0 sees goes to v1, marked and upright for the one who looks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from robotcore.runtime.result import Outcome
from tests.system.vrep import scenes
from tests.system.vrep.server import run_on

YELLOW = (255, 255, 0)


@pytest.fixture(autouse=True)
def _built() -> Iterator[None]:
    with scenes.relay():
        yield


def require_marked() -> None:
    """The rectangle is on the lower left, where the ball is before v0."""
    pixels = np.frombuffer(scenes.read_screen(), np.uint8).reshape(scenes.SIGHT_PX, scenes.SIGHT_PX, 3)
    rows, columns = np.nonzero((abs(pixels[::-1].astype(int) - YELLOW) < 60).all(axis=2))
    assert len(rows), "no rectangle"
    middle = scenes.SIGHT_PX / 2
    assert (rows.mean() > middle, columns.mean() < middle) == (True, True), (rows.mean(), columns.mean())


@pytest.mark.parametrize("stepped", [True, False])
def test_marked_picture_is_on_the_second_sensor_upright(*, stepped: bool) -> None:
    with scenes.running():
        result = run_on("mark-green", more={"stepped": stepped})
        assert (result.outcome, "seen" in result.milestones) == (Outcome.SUCCESS, True), result.reason
        require_marked()


def test_marked_picture_stays_when_the_simulation_was_started_for_it() -> None:
    result = run_on("mark-green")
    assert (result.outcome, "seen" in result.milestones) == (Outcome.SUCCESS, True), result.reason
    require_marked()
