"""The conformance kit on a board's double: a rover whose devices are on a pty, in simulated time."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar

import pytest

from drivers.serial import backend as module
from drivers.serial.backend import SECTION, SerialBackend
from robotcore.description import RobotDescription, load_robot
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.testing import Capability
from robotcore.testing.bench import RATE_HZ, Bench
from tests.doubles.serial.board import PERIOD_S, BoardDouble, Powered
from tests.doubles.serial.pty import Pty


class SerialBench(Bench):
    """Say which ``devices`` of the rover are on the board, each with its section, but for the port; and the board.

    >>> class TestMyBoard(SerialBench, ConformanceSuite):
    ...     devices = {"left_motor": {"driver": "my-motor", "side": "left"}}
    ...     def board(self): return MyBoard(Wheels())
    """

    backend = SerialBackend
    devices: ClassVar[Mapping[str, Mapping[str, Any]]]
    extra: ClassVar[tuple[Any, ...]] = ()
    """Descriptions of devices that the rover has not, such as a battery."""

    lacks: ClassVar[Mapping[Capability, str]] = {
        Capability.WORLD: "there are wheels behind the board, and no world around them",
        Capability.LOST_ECHO: "nothing on the board listens for echoes",
        Capability.SLOW_HARDWARE: "in simulated time nobody waits",
    }

    @abstractmethod
    def board(self) -> BoardDouble:
        """Return a new board, as it is when it gets power."""

    @property
    def description(self) -> RobotDescription:
        return wired(load_robot("rover"), self.devices, self.pty.path, self.extra)

    @pytest.fixture(autouse=True)
    def _on_a_pty(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
        with Pty(tmp_path) as self.pty:
            monkeypatch.setattr(module, "MonotonicClock", self._clock_with_a_board)
            yield

    def _clock_with_a_board(self) -> Clock:
        clock = SteppedClock(RATE_HZ, lambda _steps: None, PERIOD_S)
        self.powered = Powered(self.board(), self.pty, clock)
        return clock


def wired(
    robot: RobotDescription, devices: Mapping[str, Mapping[str, Any]], port: Path, extra: tuple[Any, ...] = ()
) -> RobotDescription:
    """Return a robot with these devices alone, on one port; its drive where both motors are among them."""
    kept = tuple(told for told in (*robot.devices, *extra) if told.name in devices)
    section = {name: {"port": str(port), **told} for name, told in devices.items()}
    drive = robot.drive if {"left_motor", "right_motor"} <= devices.keys() else None
    if drive and "left_encoder" not in devices:
        drive = drive.model_copy(update={"left_encoder": None, "right_encoder": None})
    return robot.model_copy(update={"devices": kept, "drive": drive, "backends": {SECTION: section}})
