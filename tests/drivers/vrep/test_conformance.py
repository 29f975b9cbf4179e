"""The conformance kit in lockstep, and its rules for time, motors and ranges without lockstep."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from typing import ClassVar

import pytest

from drivers.vrep.backend import VrepBackend
from robotcore.hal.backend import Capability, Setup
from robotcore.hal.robot import Robot
from robotcore.testing import ConformanceSuite, TestSupport, worlds
from robotcore.testing.bench import TestBench
from robotcore.testing.lifecycle_rules import LifecycleRules
from robotcore.testing.motor_rules import MotorRules
from robotcore.testing.range_rules import RangeRules
from robotcore.testing.time_rules import ClockRules, SampleRules
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scene.pacing import Pacer
from tests.doubles.coppeliasim.scenes import described_scene

PACE = 5
"""The speed of a simulation without lockstep, relative to real time."""

EVERY_ECHO = "every ray that is cast is answered"
NO_HARDWARE = "there is no hardware to wait for"


class LegacyBench(TestBench):
    """A test bench with a new server for each robot."""

    backend = VrepBackend
    servers: ExitStack

    @pytest.fixture(autouse=True)
    def _close_servers(self) -> Iterator[None]:
        with ExitStack() as self.servers:
            yield

    def open(self, setup: Setup) -> Robot:
        simulator = described_scene(self.description, setup.world or worlds.empty())
        return super().open(replace(setup, options={**self.serve(simulator), **setup.options}))

    def serve(self, simulator: Simulator) -> dict[str, object]:
        """Start a server of a scene, and return the backend options with its port."""
        return {"port": self.servers.enter_context(LegacyServer(simulator)).port}


class TestVrep(LegacyBench, ConformanceSuite):
    lacks: ClassVar = {TestSupport.LOST_ECHO: EVERY_ECHO, TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class FreeRunningVrep(VrepBackend):
    capabilities = frozenset({Capability.POSE})


@pytest.mark.conformance
class TestFreeRunningVrep(LegacyBench, LifecycleRules, ClockRules, MotorRules, RangeRules, SampleRules):
    backend = FreeRunningVrep
    lacks: ClassVar = {
        TestSupport.LOST_ECHO: EVERY_ECHO,
        TestSupport.SLOW_HARDWARE: NO_HARDWARE,
        TestSupport.MOTION: "time advances during measurements; see test_connection",
    }

    @pytest.fixture(autouse=True)
    def _set_pace(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(Pacer, "_period", staticmethod(lambda simulator: simulator.time_step / PACE))

    def serve(self, simulator: Simulator) -> dict[str, object]:
        server = self.servers.enter_context(LegacyServer(simulator))
        with simulator.lock:
            simulator.start()
        return {"port": server.start_temporary().port, "stepped": False}
