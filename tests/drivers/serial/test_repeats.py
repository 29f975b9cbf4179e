"""In simulated time what goes over a line comes at the same times, though the kernel hands it over."""

from __future__ import annotations

from typing import ClassVar

from drivers.serial.backend import SerialBackend
from robotcore.hal.backend import Vouch
from robotcore.testing.repeat_rules import RepeatRules
from tests.doubles.serial.bench import SerialBench
from tests.doubles.serial.rosarduino import OurDouble

SIDES = ("left", "right")


class Pumped(SerialBackend):
    vouches_for = frozenset({Vouch.LOCKSTEP})


class TestTwoRuns(SerialBench, RepeatRules):
    backend = Pumped
    devices: ClassVar = {
        **{f"{side}_motor": {"driver": "ros-arduino-motor", "side": side} for side in SIDES},
        **{f"{side}_encoder": {"driver": "ros-arduino-encoder", "side": side} for side in SIDES},
    }

    def board(self) -> OurDouble:
        return OurDouble(counts_per_turn=3840)
