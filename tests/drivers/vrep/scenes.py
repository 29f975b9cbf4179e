"""The conformance kit on the double."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace

import pytest

from drivers.vrep.backend import VrepBackend
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.testing import worlds
from robotcore.testing.bench import TestBench
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene import Simulator
from tests.doubles.coppeliasim.scenes import described_scene


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
