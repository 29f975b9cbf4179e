"""The sketch's config.h: what a user of the simulated robot edits in it, and which pins it names."""

from __future__ import annotations

import re
from pathlib import Path

from tests.system.firmware.wiring import Side, Wiring

ROVER = {
    "BATTERY_PIN": "A0",
    "START_DUTY": 26,  # a dead band of 0.1
    "FULL_SPEED": 71,  # 14 rad/s, 960 counts a turn
}
"""What a user edits for the robot that `Wiring` describes."""

FULL_V = 5.0
"""An analog channel tells no more than the board's own supply."""


def wiring(sketch: Path) -> Wiring:
    """Return a robot that is wired as a sketch's config.h says."""
    told = dict(re.findall(r"(?m)^#define (\w+) (\w+)", (sketch / "config.h").read_text()))

    def pin(name: str) -> int:
        return _number(told[f"{name}_PIN"])

    def side(name: str) -> Side:
        words = ("FORWARD", "BACKWARD", "ENCODER_A", "ENCODER_B", "ENABLE")
        return Side(*(pin(f"{name}_{word}") for word in words))

    return Wiring(
        side("LEFT"),
        side("RIGHT"),
        trigger=pin("SONAR_TRIGGER"),
        echo=pin("SONAR_ECHO"),
        battery=pin("BATTERY") - _number("A0"),
        battery_ratio=1000 * FULL_V / int(told["BATTERY_FULL_SCALE_MV"]),
    )


def _number(pin: str) -> int:
    """Return the number of a pin that Arduino also calls A0 to A5."""
    return 14 + int(pin[1:]) if pin.startswith("A") else int(pin)
