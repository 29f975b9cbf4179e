from __future__ import annotations

import pytest

from robotcore import Outcome, RunRequest, run


def test_drives_for_ten_seconds_by_default() -> None:
    result = run(RunRequest("avoid-obstacles", world="open"))
    assert result.outcome is Outcome.SUCCESS
    assert result.sim_time_s == pytest.approx(10.0)


@pytest.mark.parametrize("world", ["arena", "clutter"])
def test_turns_away_from_obstacles(world: str) -> None:
    result = run(RunRequest("avoid-obstacles", world=world, settings={"duration_s": 30}))
    assert (result.outcome, result.contacts) == (Outcome.SUCCESS, 0)
    assert "avoid" in result.milestones
