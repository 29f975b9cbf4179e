"""Recorded drives of a rover, and the description of a rover with other wheels and motors."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, ClassVar

import robotcore.description
from robotcore import Behaviour, Robot, Role, Status
from robotcore.recording import Recording
from tests.robotcore.recording.replay.memory import record_run

ROBOTS = Path(robotcore.description.__file__).parent / "robots"
ROVER = (ROBOTS / "rover.toml").read_text()
MODEL = "model = { dead_band = 0.10, forward_rad_s = 14.0, backward_rad_s = 14.0 }"


class Winding(Behaviour):
    """Drives curves in both directions, and reads the range sensor and the camera."""

    needs: ClassVar = {Role.DRIVE, Role.RANGE, Role.CAMERA}

    def step(self, robot: Robot) -> Status:
        time = robot.clock.now()
        robot.range.read()
        if round(time * 20) % 5 == 0:
            robot.camera.read()
        robot.drive.set_velocity(-0.15 if 2 < time < 3 else 0.2, math.copysign(0.8, math.sin(time * 2)))
        return Status.RUNNING


def record(app: type[Behaviour] = Winding, **asked: Any) -> Recording:
    return record_run(app, **{"world": "arena", "seed": 3, "timeout_s": 4.0, **asked})


CHANGES = (
    (MODEL, "model = { dead_band = 0.15, forward_rad_s = 12.9, backward_rad_s = 13.8 }"),
    (MODEL, "model = { dead_band = 0.07, forward_rad_s = 15.0, backward_rad_s = 14.3 }"),
    ("track_m = 0.155", "track_m = 0.159"),
    ("wheel_radius_m = 0.0325", "wheel_radius_m = 0.0333"),
    *[("lag_s = 0.05", "lag_s = 0.09")] * 2,
)


def write_truth(file: Path) -> str:
    """Write the description of a rover with other motors, wheels and lags than the shipped one, and return its path."""
    text = ROVER
    for old, new in CHANGES:
        assert old in text
        text = text.replace(old, new, 1)
    file.write_text(text)
    return str(file)
