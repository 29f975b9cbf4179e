"""Tests in addition to the conformance kit: the backend's name, and the failures of its board."""

from pathlib import Path

import pytest
from robotcore import Outcome, RunRequest, run
from robotcore.description import load_robot
from robotcore.errors import DeviceError
from robotcore.hal.backend import Setup
from robotcore.plugins import backend_names

from my_board.backend import MyBoardBackend
from my_board.board import Board

ROBOT = str(Path(__file__).parents[1] / "my_board.toml")


class Unplugged(Board):
    """A board that answers until it is unplugged."""

    is_unplugged = False

    def distance(self) -> float:
        if self.is_unplugged:
            raise ConnectionError
        return super().distance()


def test_an_app_runs_on_the_backend() -> None:
    assert "my-board" in backend_names(), "install it first: pip install -e ."
    result = run(RunRequest("avoid-obstacles", backend="my-board", robot=ROBOT))
    assert result.outcome is Outcome.SUCCESS
    assert "avoid" in result.milestones


def test_an_unplugged_board_is_named_in_the_error() -> None:
    board = Unplugged()
    setup = Setup(load_robot(ROBOT), None, frozenset({"nose"}))
    with MyBoardBackend(lambda: board).open(setup) as robot:
        board.is_unplugged = True
        robot.clock.sleep_until(0.1)
        with pytest.raises(DeviceError) as caught:
            robot.range.read()
    assert (caught.value.device, caught.value.kind) == ("nose", "board-silent")


def test_a_device_that_the_board_lacks_is_named() -> None:
    setup = Setup(load_robot("rover"), None, frozenset({"nose", "eye"}))
    with pytest.raises(DeviceError, match="eye: "):
        MyBoardBackend().open(setup)
