"""A TFmini on a line keeps the kit's rules; a simulator is in front of it, and the rest of the robot is its own."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import pytest

from drivers.kinematic.backend import KinematicBackend
from robotcore.description import RobotDescription
from robotcore.hal.backend import Setup
from robotcore.hal.devices import RangeSensor
from robotcore.hal.robot import Robot
from robotcore.hardware import open_robot
from robotcore.testing import Capability
from robotcore.testing.lifecycle_rules import LifecycleRules
from robotcore.testing.range_rules import RangeRules
from robotcore.testing.sample_rules import SampleRules
from tests.doubles.serial.board import Powered
from tests.doubles.serial.pty import Pty
from tests.doubles.serial.tfmini import REACH_M, TFminiS
from tests.drivers.serial.ranging.rig import TOLD, robot_with


@pytest.mark.conformance
class TestTFmini(LifecycleRules, RangeRules, SampleRules):
    backend = KinematicBackend
    lacks: ClassVar = {Capability.SLOW_HARDWARE: "reading never asks the line: it talks by itself"}

    @pytest.fixture(autouse=True)
    def _folder(self, tmp_path: Path) -> None:
        self._path = tmp_path

    @property
    def description(self) -> RobotDescription:
        return robot_with(TOLD, nose={"driver": "tfmini", "port": str(self._path / "board")})

    def open(self, setup: Setup) -> Robot:
        seen = robot_with(TOLD.model_copy(update={"max_range_m": REACH_M}))
        with ExitStack() as undo:
            simulated = undo.enter_context(KinematicBackend().open(replace(setup, robot=seen)))
            pty = undo.enter_context(Pty(self._path))
            self.double = TFminiS(_distance(simulated))
            undo.callback(Powered(self.double, pty, simulated.clock).off)
            release = undo.pop_all().close
        others = {name: device for name, device in simulated.devices.items() if not isinstance(device, RangeSensor)}
        return open_robot(setup, "serial", simulated.clock, release=release, truth=simulated.truth, opened=others)

    def lose_echoes(self, robot: Robot) -> None:
        self.double.is_blind = True


def _distance(simulated: Robot) -> Callable[[], float]:
    """Return how far away what is in front of the robot is; nobody asks where it has no range sensor open."""
    noses = [device for device in simulated.devices.values() if isinstance(device, RangeSensor)]
    return lambda: noses[0].read().distance if noses else math.inf
