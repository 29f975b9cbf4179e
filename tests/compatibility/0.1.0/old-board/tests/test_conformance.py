"""Test the backend with robotcore's conformance kit. Each rule that cannot be tested has a reason."""

from pathlib import Path
from typing import ClassVar

from robotcore.geometry import Pose
from robotcore.hal.backend import Setup
from robotcore.hal.clock import Clock
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.testing import ConformanceSuite, Gate, TestSupport

from old_board.backend import OldBoardBackend
from old_board.board import Board


class TestOldBoard(ConformanceSuite):
    backend = OldBoardBackend
    robot = str(Path(__file__).parents[1] / "old_board.toml")
    lacks: ClassVar = {
        TestSupport.WORLD: "the board has one wall only",
        TestSupport.LOST_ECHO: "the board always measures the wall",
    }

    def open(self, setup: Setup) -> Robot:
        self._board = FragileBoard()
        return OldBoardBackend(lambda: self._board).open(setup)

    def unplug(self, robot: Robot) -> None:
        self._board.is_unplugged = True

    def measure_pose(self, robot: Robot) -> Pose:
        return self._board.pose

    def open_gated(self, setup: Setup, gate: Gate) -> Robot:
        return OldBoardBackend(lambda: SlowBoard(gate)).open(setup)


class FragileBoard(Board):
    """A board that answers until it is unplugged."""

    is_unplugged = False

    def turn(self, wheel: str, rad_s: float) -> None:
        self._require_plug()
        super().turn(wheel, rad_s)

    def angle(self, wheel: str) -> float:
        self._require_plug()
        return super().angle(wheel)

    def distance(self) -> float:
        self._require_plug()
        return super().distance()

    def voltage(self) -> float:
        self._require_plug()
        return super().voltage()

    def _require_plug(self) -> None:
        if self.is_unplugged:
            raise ConnectionError


class SlowBoard(Board):
    """A board in real time that answers only while the test's gate is open."""

    def __init__(self, gate: Gate) -> None:
        super().__init__()
        self._gate = gate

    def clock(self, rate_hz: float) -> Clock:
        return MonotonicClock()

    def turn(self, wheel: str, rad_s: float) -> None:
        self._gate.pass_through()
        super().turn(wheel, rad_s)

    def angle(self, wheel: str) -> float:
        self._gate.pass_through()
        return super().angle(wheel)

    def distance(self) -> float:
        self._gate.pass_through()
        return super().distance()

    def voltage(self) -> float:
        self._gate.pass_through()
        return super().voltage()
