from __future__ import annotations

from typing import ClassVar

from robotcore.description import RobotDescription
from robotcore.testing import TestSupport
from tests.robotcore.simulation.remote_scene.memory import MemoryBackend, rover
from tests.robotcore.testing.variant_suites import DriveAndRangeSuite


class TestJoined(DriveAndRangeSuite):
    backend = MemoryBackend
    lacks: ClassVar = {
        TestSupport.LOST_ECHO: "every ray that is cast is answered",
        TestSupport.SLOW_HARDWARE: "there is no hardware to wait for",
    }

    @property
    def description(self) -> RobotDescription:
        return rover()
