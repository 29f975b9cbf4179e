"""Every backend passes the conformance kit, except for rules that cannot be tested on it."""

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
from tests.drivers.coppeliasim import test_conformance as coppeliasim_suites
from tests.drivers.raspberrypi import test_conformance as raspberrypi_suites
from tests.drivers.raspberrypi.virtual import test_conformance as virtual_pi_suites
from tests.drivers.serial.boards import test_conformance as serial_suites
from tests.drivers.vrep import test_conformance as vrep_suites
from tests.robotcore.recording.replay.memory import record_run
from tests.robotcore.testing.variant_suites import DriveInSimulatorSuite, EquippedSuite, SkidInSimulatorSuite

NO_LOST_ECHO = "the simulator answers every ray"
NO_HARDWARE = "the backend has no hardware"


class TestKinematic(ConformanceSuite):
    backend = KinematicBackend
    lacks: ClassVar = {TestSupport.LOST_ECHO: NO_LOST_ECHO, TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestPyBullet(ConformanceSuite):
    backend = PyBulletBackend
    lacks: ClassVar = {TestSupport.LOST_ECHO: NO_LOST_ECHO, TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestMujoco(ConformanceSuite):
    backend = MujocoBackend
    lacks: ClassVar = {TestSupport.LOST_ECHO: NO_LOST_ECHO, TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestSkidInKinematic(SkidInSimulatorSuite):
    backend = KinematicBackend
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestSteeringInKinematic(DriveInSimulatorSuite):
    backend, robot = KinematicBackend, "picar"
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestSkidInMock(SkidInSimulatorSuite):
    backend = MockBackend
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestSteeringInMock(DriveInSimulatorSuite):
    backend, robot = MockBackend, "picar"
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestSkidInPyBullet(SkidInSimulatorSuite):
    backend = PyBulletBackend
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestSkidInMujoco(SkidInSimulatorSuite):
    backend = MujocoBackend
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestSteeringInPyBullet(DriveInSimulatorSuite):
    backend, robot = PyBulletBackend, "picar"
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestSteeringInMujoco(DriveInSimulatorSuite):
    backend, robot = MujocoBackend, "picar"
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: NO_HARDWARE}


class TestDevicesInKinematic(EquippedSuite):
    backend = KinematicBackend


class TestDevicesInPyBullet(EquippedSuite):
    backend = PyBulletBackend


class TestDevicesInMujoco(EquippedSuite):
    backend = MujocoBackend


class TestDevicesInMock(EquippedSuite):
    backend = MockBackend


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
        TestSupport.WORLD: "its sensors return the recorded samples",
        TestSupport.MOTION: "the motors of a replay ignore their commands",
        TestSupport.LOST_ECHO: "its range sensor returns the recorded samples",
        TestSupport.SLOW_HARDWARE: NO_HARDWARE,
    }

    def open(self, setup: Setup) -> Robot:
        return super().open(replace(setup, options={"recording": _record_search(), **setup.options}))


@cache
def _record_search() -> Recording:
    """Return the recording of a run that reads every sensor in each tick."""
    return record_run("green-search", seed=7, timeout_s=6.0)


def test_every_backend_has_a_suite() -> None:
    hardware = (raspberrypi_suites.TestRaspberryPi, virtual_pi_suites.TestVirtualPi, serial_suites.TestRobotcoreBridge)
    remote = (coppeliasim_suites.TestBuilt, vrep_suites.TestVrep)
    suites = (TestKinematic, TestPyBullet, TestMujoco, TestMock, TestReplay, *hardware, *remote)
    assert sorted(suite.backend.name for suite in suites) == backend_names()
