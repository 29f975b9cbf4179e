from __future__ import annotations

import pytest

from robotcore import Outcome, RunRequest, RunResult, run
from robotcore.autonomy.vision.colour_detector import YELLOW
from robotcore.runtime.session import RunContext
from robotcore.runtime.trace import TickRecord

SEED = 6
"""With this seed, the ball is in front of both robots."""


class DisplayRecorder:
    """Stores the last picture that the display showed."""

    def begin(self, run: RunContext) -> None:
        self._display = run.robot.display

    def tick(self, record: TickRecord) -> None:
        self.picture = getattr(self._display, "latest")  # noqa: B009  only AppDisplay has this attribute

    def end(self, result: RunResult) -> None:
        pass


@pytest.mark.parametrize("robot", ["lookout", "rover"])
def test_shows_a_yellow_rectangle_around_the_ball(robot: str) -> None:
    recorder = DisplayRecorder()
    result = run(RunRequest("mark-green", robot=robot, world="open", seed=SEED, settings={"duration_s": 1}), [recorder])
    assert result.outcome is Outcome.SUCCESS
    assert "seen" in result.milestones
    assert (recorder.picture == YELLOW).all(axis=2).any()


def test_the_robot_lookout_sees_the_ball() -> None:
    result = run(RunRequest("mark-green", robot="lookout", world="open", seed=3, settings={"duration_s": 1}))
    assert result.milestones["seen"] == 0.0
