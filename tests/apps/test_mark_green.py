from __future__ import annotations

import pytest

from robotcore import Outcome, RunRequest, RunResult, run
from robotcore.autonomy.vision.annotate import YELLOW
from robotcore.runtime.session import Run
from robotcore.runtime.trace import TickRecord

SEED = 6
"""Both robots have the ball before them."""


class Watcher:
    """Keeps the last picture that was shown."""

    def begin(self, run: Run) -> None:
        self._display = run.robot.display

    def tick(self, record: TickRecord) -> None:
        self.picture = getattr(self._display, "latest")  # noqa: B009  what the layers add

    def end(self, result: RunResult) -> None:
        pass


@pytest.mark.parametrize("robot", ["lookout", "rover"])
def test_shows_a_yellow_rectangle_round_the_ball(robot: str) -> None:
    watcher = Watcher()
    result = run(RunRequest("mark-green", robot=robot, world="open", seed=SEED, settings={"duration_s": 1}), [watcher])
    assert result.outcome is Outcome.SUCCESS
    assert "seen" in result.milestones
    assert (watcher.picture == YELLOW).all(axis=2).any()


def test_the_lookout_sees_the_ball() -> None:
    result = run(RunRequest("mark-green", robot="lookout", world="open", seed=3, settings={"duration_s": 1}))
    assert result.milestones["seen"] == 0.0
