"""Run the conformance kit."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

from drivers.coppeliasim.backend import CoppeliaSimBackend
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.testing import ConformanceSuite, TestSupport
from tests.system.coppeliasim.server import options


class TestBuilt(ConformanceSuite):
    backend = CoppeliaSimBackend
    lacks: ClassVar = {
        TestSupport.LOST_ECHO: "every depth picture has all distances",
        TestSupport.SLOW_HARDWARE: "there is no hardware to wait for",
        TestSupport.CUTOFFS: "the motors of an open robot set a velocity before each time step",
        TestSupport.REPRODUCIBLE: "its physics do not repeat to the bit",
    }

    def open(self, setup: Setup) -> Robot:
        return super().open(replace(setup, options={**options(), **setup.options}))
