"""A hoverboard's devices keep the kit's rules, in the modes and with the mixers that its firmware may have."""

from __future__ import annotations

from typing import Any, ClassVar

from robotcore.description import BatteryDescription
from robotcore.testing import ConformanceSuite
from tests.doubles.serial.board import BoardDouble
from tests.doubles.serial.hoverboard import Firmware, Hoverboard
from tests.doubles.serial.ticking import TickingBench
from tests.doubles.serial.wheels import Wheels

SIDES = ("left", "right")
FULL_RAD_S = 40.0


def devices(**motor: Any) -> dict[str, dict[str, Any]]:
    """Return the sections of both motors, both encoders and the battery."""
    motors = {f"{side}_motor": {"driver": "hoverboard-motor", "side": side, **motor} for side in SIDES}
    encoders = {f"{side}_encoder": {"driver": "hoverboard-encoder", "side": side} for side in SIDES}
    return {**motors, **encoders, "battery": {"driver": "hoverboard-battery"}}


class TestHoverboardHoldingSpeed(TickingBench, ConformanceSuite):
    devices: ClassVar = devices(mode="speed")
    extra: ClassVar = (BatteryDescription(kind="battery", name="battery"),)

    def board(self) -> BoardDouble:
        return Hoverboard(Wheels())


class TestHoverboardByDuty(TestHoverboardHoldingSpeed):
    devices: ClassVar = devices(
        mode="duty", tank_steering=True, model={"forward_rad_s": FULL_RAD_S, "backward_rad_s": FULL_RAD_S}
    )

    def board(self) -> BoardDouble:
        return Hoverboard(Wheels(), Firmware(is_tank=True, rad_s_per_unit=FULL_RAD_S / 1000))
