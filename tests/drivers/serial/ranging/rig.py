"""A TFmini on a pty, and the driver that listens to it, in simulated time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from drivers.serial.ranging.tfmini import TFmini, TFminiSettings
from robotcore.clock import SteppedClock
from robotcore.description import RangeSensorDescription, RobotDescription, load_robot
from robotcore.devices import RangeSensor
from robotcore.hardware import Host
from robotcore.polling import Polling
from tests.doubles.serial.pty import Pty
from tests.doubles.serial.tfmini import PERIOD_S, frame

_NOSE = next(device for device in load_robot("rover").devices if isinstance(device, RangeSensorDescription))
TOLD = _NOSE.model_copy(update={"min_range_m": 0.1, "cone_rad": 0.063})
"""A beam of 3.6 degrees."""


def robot_with(*noses: RangeSensorDescription, **wires: Mapping[str, Any]) -> RobotDescription:
    """Return the rover with these in place of its own, and these tables in its section [serial]."""
    rover = load_robot("rover")
    others = [device for device in rover.devices if not isinstance(device, RangeSensorDescription)]
    return rover.model_copy(update={"devices": (*others, *noses), "backends": {"serial": wires}})


class Rig:
    """A sensor that sends what ``says`` is, every hundredth of a second."""

    def __init__(self, folder: Path) -> None:
        self.pty = Pty(folder)
        self.clock = SteppedClock(500, lambda _steps: None)
        self.says = frame(50)
        self._talking: Polling = self.clock.every(PERIOD_S, self._tell, "TFmini")

    def open(self, **settings: Any) -> RangeSensor:
        host = Host(load_robot("rover"), self.clock)
        return TFmini().open(TOLD, TFminiSettings(port=str(self.pty.path), **settings), host)

    def say(self, *frames: bytes) -> None:
        """Send frames at once, and go on with the last of them."""
        self.pty.say_all(b"".join(frames))
        self.says = frames[-1]

    def fall_silent(self) -> None:
        self.says = b""

    def cycles(self, count: int = 1) -> None:
        self.clock.sleep_until(self.clock.now() + PERIOD_S * count)

    def close(self) -> None:
        self.pty.close()

    def _tell(self) -> None:
        self.pty.say_all(self.says)
