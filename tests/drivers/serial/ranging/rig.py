"""A TFmini on a pty, and its driver, in simulated time."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from drivers.serial.ranging.tfmini import TFmini, TFminiSettings
from robotcore.description import RangeSensorDescription, RobotDescription, load_robot
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import RangeSensor
from robotcore.hardware import Host
from tests.doubles.serial.board import Powered
from tests.doubles.serial.pty import Pty
from tests.doubles.serial.tfmini import PERIOD_S, TFminiS, frame

_NOSE = next(device for device in load_robot("rover").devices if isinstance(device, RangeSensorDescription))
NOSE = _NOSE.model_copy(update={"min_range_m": 0.1, "cone_rad": 0.063})
"""A beam of 3.6 degrees."""


def robot_with(*noses: RangeSensorDescription, **wires: Mapping[str, Any]) -> RobotDescription:
    """Return the rover with these range sensors in place of its own, and with these tables in [serial]."""
    rover = load_robot("rover")
    others = [device for device in rover.devices if not isinstance(device, RangeSensorDescription)]
    return rover.model_copy(update={"devices": (*others, *noses), "backends": {"serial": wires}})


class Rig:
    """A sensor that sends the distance 0.5 m until `set_frames` changes its frames."""

    def __init__(self, folder: Path) -> None:
        self.pty, self.clock, self.double = Pty(folder), SteppedClock(500, lambda _steps: None), TFminiS()
        self.set_frames(frame(50))
        self._opened = ExitStack()
        self._opened.enter_context(self.pty)
        self._opened.callback(Powered(self.double, self.pty, self.clock).off)

    def open(self, **settings: Any) -> RangeSensor:
        host = Host(load_robot("rover"), self.clock)
        sensor = TFmini().open(NOSE, TFminiSettings(port=str(self.pty.path), **settings), host)
        self._opened.callback(sensor.close)
        return sensor

    def set_frames(self, *frames: bytes, cycles: int = 0) -> None:
        """Set the frames that the sensor sends together in each cycle of 10 ms; let ``cycles`` cycles pass."""
        self.double.replacement = b"".join(frames)
        self.cycles(cycles)

    def cycles(self, count: int = 1) -> None:
        self.clock.sleep_until(self.clock.now() + PERIOD_S * count)

    def close(self) -> None:
        self._opened.close()
