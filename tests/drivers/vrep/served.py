"""The kit on doubles: each robot that a rule opens gets a server of its own, with its world behind it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace

import pytest

from drivers.vrep.backend import VrepBackend
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.testing import ConformanceSuite, worlds
from tests.doubles.coppeliasim.legacy.server import LegacyServer
from tests.doubles.coppeliasim.scene.simulator import Simulator
from tests.doubles.coppeliasim.scenes import described_scene


class OnDoubles(ConformanceSuite):
    """Servers end with the rule that needed them."""

    backend = VrepBackend
    servers: ExitStack

    @pytest.fixture(autouse=True)
    def _serving(self) -> Iterator[None]:
        with ExitStack() as self.servers:
            yield

    def open(self, setup: Setup) -> Robot:
        simulator = described_scene(self.description, setup.world or worlds.empty())
        return super().open(replace(setup, options={**self.serve(simulator), **setup.options}))

    def serve(self, simulator: Simulator) -> dict[str, object]:
        """Serve a scene; return the options that lead there."""
        return {"port": self.servers.enter_context(LegacyServer(simulator)).port}
