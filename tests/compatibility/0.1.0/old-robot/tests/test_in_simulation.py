"""Run the app in rooms drawn from a seed. The simulator verifies each success."""

from pathlib import Path

import pytest
from robotcore import RunRequest, run

FOLDER = Path(__file__).parents[1]
APP = str(FOLDER / "search.py")
ROBOT = str(FOLDER / "old_robot.toml")
WORLD = str(FOLDER / "room.toml")


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_finds_the_ball_in_rooms_drawn_from_a_seed(seed: int) -> None:
    result = run(RunRequest(APP, robot=ROBOT, world=WORLD, seed=seed))
    assert result.verified, f"{result.outcome.value}: {result.reason or result}"
