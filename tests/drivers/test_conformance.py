"""Every backend keeps the kit's rules, or says why a rule cannot be checked on it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any, ClassVar

from drivers.kinematic.backend import KinematicBackend
from drivers.mujoco.backend import MujocoBackend
from drivers.pybullet.backend import PyBulletBackend
from drivers.replay.backend import ReplayBackend
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.plugins import backend_names
from robotcore.recording import Recording
from robotcore.testing import ConformanceSuite, TestSupport
from robotcore.testing.mock.backend import MockBackend
from robotcore.testing.mock.devices import LOST
from tests.drivers.coppeliasim import test_conformance as over_zeromq
from tests.drivers.raspberrypi import test_conformance as on_a_pi
from tests.drivers.raspberrypi.virtual import test_conformance as on_virtual_pins
from tests.drivers.serial.boards.rosarduino import test_conformance as on_a_line
from tests.drivers.vrep import test_conformance as over_the_legacy_api
from tests.robotcore.recording.replay.memory import recorded

EVERY_ECHO = "every ray that is cast is answered"
NO_HARDWARE = "there is no hardware to wait for"


class TestKinematic(ConformanceSuite):
    backend = KinematicBackend
    lacks: ClassVar = {TestSupport.LOST_ECHO: EVERY_ECHO, TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestPyBullet(ConformanceSuite):
    backend = PyBulletBackend
    lacks: ClassVar = {TestSupport.LOST_ECHO: EVERY_ECHO, TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestMujoco(ConformanceSuite):
    backend = MujocoBackend
    lacks: ClassVar = {TestSupport.LOST_ECHO: EVERY_ECHO, TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestMock(ConformanceSuite):
    backend = MockBackend
    lacks: ClassVar = {
        TestSupport.WORLD: "its sensors follow a script",
        TestSupport.SLOW_HARDWARE: NO_HARDWARE,
    }
    is_lost = False

    def open(self, setup: Setup) -> Robot:
        return MockBackend({"nose": self.echo}).open(setup)

    def lose_echoes(self, robot: Robot) -> None:
        self.is_lost = True

    def echo(self, time: float) -> Any:
        return LOST if self.is_lost else 1.0


class TestReplay(ConformanceSuite):
    backend = ReplayBackend
    lacks: ClassVar = {
        TestSupport.WORLD: "it shows the world that was recorded",
        TestSupport.MOTION: "nothing moves: a replay compares the motors' commands with the recorded ones",
        TestSupport.LOST_ECHO: "the recording says which echoes were lost",
        TestSupport.SLOW_HARDWARE: NO_HARDWARE,
    }

    def open(self, setup: Setup) -> Robot:
        return super().open(replace(setup, options={"recording": _search(), **setup.options}))


@cache
def _search() -> Recording:
    """A run that read every sensor in each tick."""
    return recorded("green-search", seed=7, timeout_s=6.0)


def test_every_backend_is_tried() -> None:
    on_wires = (on_a_pi.TestRaspberryPi, on_virtual_pins.TestVirtualPi, on_a_line.TestOurFirmware)
    on_servers = (over_zeromq.TestBuilt, over_the_legacy_api.TestVrep)
    suites = (TestKinematic, TestPyBullet, TestMujoco, TestMock, TestReplay, *on_wires, *on_servers)
    assert sorted(suite.backend.name for suite in suites) == backend_names()
