"""A rover on a Waveshare UGV board keeps the kit's rules in simulated time."""

from __future__ import annotations

from typing import ClassVar

from robotcore.description import BatteryDescription
from robotcore.testing import ConformanceSuite
from tests.doubles.serial.bench import SerialBench
from tests.doubles.serial.waveshare import WaveshareBoard

SIDES = ("left", "right")


class TestWaveshare(SerialBench, ConformanceSuite):
    devices: ClassVar = {
        **{f"{side}_motor": {"driver": "waveshare-motor", "side": side, "board_timeout_s": 5} for side in SIDES},
        **{f"{side}_encoder": {"driver": "waveshare-encoder", "side": side} for side in SIDES},
        "battery": {"driver": "waveshare-battery"},
    }
    extra: ClassVar = (BatteryDescription(kind="battery", name="battery"),)

    def board(self) -> WaveshareBoard:
        return WaveshareBoard(2 * self.drive.wheel_radius_m)
