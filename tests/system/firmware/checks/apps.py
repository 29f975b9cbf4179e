"""The apps, on a robot whose motors, encoders and range sensor are on the firmware."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.runtime.plan import RunRequest
from robotcore.runtime.result import Outcome
from robotcore.runtime.session import run
from tests.system.firmware.config import write_rover_file


@pytest.fixture
def rover(tmp_path: Path) -> str:
    return str(write_rover_file(tmp_path / "rover.toml"))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_green_search_finds_the_ball(rover: str, seed: int) -> None:
    result = run(RunRequest("green-search", "simavr", rover, world="arena", seed=seed))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


def test_obstacles_are_avoided(rover: str) -> None:
    result = run(RunRequest("avoid-obstacles", "simavr", rover, world="clutter", settings={"duration_s": 10.0}))
    assert (result.outcome, result.contacts) == (Outcome.SUCCESS, 0), result.reason
