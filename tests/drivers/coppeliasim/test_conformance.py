"""The conformance kit in a built scene, and its rules for drives and ranges in an existing scene."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from typing import ClassVar

import pytest

from drivers.coppeliasim.backend import CoppeliaSimBackend
from robotcore.description import RobotDescription
from robotcore.hal.backend import Capability, Setup
from robotcore.hal.robot import Robot
from robotcore.testing import ConformanceSuite, TestSupport, worlds
from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scenes import default_scene, described_scene
from tests.drivers.coppeliasim.servers import load_joined_robot
from tests.robotcore.testing.variant_suites import DriveAndRangeSuite

EVERY_ECHO = "every ray that is cast is answered"
NO_HARDWARE = "there is no hardware to wait for"
LACKS = {TestSupport.LOST_ECHO: EVERY_ECHO, TestSupport.SLOW_HARDWARE: NO_HARDWARE}


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    """Start one simulator for all tests, and return its port. Each robot must restore the scene."""
    with Double(default_scene()) as double:
        yield double.zmq_port


class TestBuilt(ConformanceSuite):
    backend = CoppeliaSimBackend
    lacks: ClassVar = {**LACKS, TestSupport.CUTOFFS: "the motors of an open robot set a velocity before each time step"}

    @pytest.fixture(autouse=True)
    def _set_port(self, port: int) -> None:
        self.port = port

    def open(self, setup: Setup) -> Robot:
        return super().open(replace(setup, options={"port": self.port, **setup.options}))


class JoiningBackend(CoppeliaSimBackend):
    capabilities = frozenset({Capability.POSE, Capability.LOCKSTEP})


@pytest.mark.slow
class TestJoined(DriveAndRangeSuite):
    backend = JoiningBackend
    lacks: ClassVar = LACKS
    servers: ExitStack

    @pytest.fixture(autouse=True)
    def _close_servers(self) -> Iterator[None]:
        with ExitStack() as self.servers:
            yield

    @property
    def description(self) -> RobotDescription:
        return load_joined_robot("rover")

    def open(self, setup: Setup) -> Robot:
        simulator = described_scene(self.description, setup.world or worlds.empty())
        port = self.servers.enter_context(Double(simulator)).zmq_port
        return super().open(replace(setup, options={"port": port, **setup.options}))
