"""Motors on a Sabertooth keep the kit's rules, as far as a board without encoders can show them."""

from __future__ import annotations

from typing import ClassVar

from robotcore.testing import Capability, ConformanceSuite
from tests.doubles.serial.bench import SerialBench
from tests.doubles.serial.board import BoardDouble
from tests.doubles.serial.sabertooth import Sabertooths

FULL_RAD_S = 16.0
MODEL = {"forward_rad_s": FULL_RAD_S, "backward_rad_s": FULL_RAD_S}


class TestSabertooth(SerialBench, ConformanceSuite):
    devices: ClassVar = {
        "left_motor": {"driver": "sabertooth-motor", "motor": 1, "model": MODEL},
        "right_motor": {"driver": "sabertooth-motor", "motor": 2, "model": MODEL},
    }
    lacks: ClassVar = {**SerialBench.lacks, Capability.MOTION: "the board tells nothing of its wheels"}

    def board(self) -> BoardDouble:
        return Sabertooths(full_rad_s=FULL_RAD_S)
