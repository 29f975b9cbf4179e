"""The rover on other boards than the file's, and with other encoders."""

from __future__ import annotations

from typing import Any

from robotcore.description import RobotDescription, load_robot

MODEL = {"dead_band": 0.05, "forward_rad_s": 16.0, "backward_rad_s": 15.0}


def rewired(**motor: Any) -> RobotDescription:
    """Return the rover on boards with a phase and an enable line, with encoders that have one channel."""
    rover = load_robot("rover")
    section = rover.backends["raspberrypi"] | {
        "left_motor": {"driver": "phase-enable", "phase": 17, "enable": 27, "model": MODEL, **motor},
        "right_motor": {"driver": "phase-enable", "phase": 23, "enable": 24, "model": MODEL, **motor},
        "left_encoder": {"driver": "pulses", "gpio": 5},
        "right_encoder": {"driver": "pulses", "gpio": 20},
    }
    return rover.model_copy(update={"backends": rover.backends | {"raspberrypi": section}})
