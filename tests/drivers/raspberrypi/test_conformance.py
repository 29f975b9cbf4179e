"""The backend `raspberrypi` passes the conformance kit in real time, on mock pins with an ultrasonic module."""

from __future__ import annotations

from typing import Any, ClassVar

import pytest

from drivers.raspberrypi import backend
from drivers.raspberrypi.backend import RaspberryPiBackend
from drivers.raspberrypi.ranging.ultrasonic_driver import speed_of_sound
from drivers.raspberrypi.virtual.models import VirtualEcho, VirtualPin, VirtualPins
from robotcore.description import RobotDescription, load_robot
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.testing import ConformanceSuite, Gate, TestSupport
from tests.drivers.raspberrypi.ranging.modules import FakeRange


class MockPiBackend(RaspberryPiBackend):
    """The backend on mock pins, which need no lgpio."""

    modules = ("gpiozero",)


class TestRaspberryPi(ConformanceSuite):
    backend = MockPiBackend
    lacks: ClassVar = {
        TestSupport.WORLD: "nothing but a module is on its pins",
        TestSupport.MOTION: "nothing but a module is on its pins",
        TestSupport.LOST_ECHO: "an echo may be on its way; virtualpi shows it in lockstep",
    }

    @property
    def description(self) -> RobotDescription:
        """Return the rover without its camera, which is on no pin."""
        rover = load_robot("rover")
        wiring = {name: wires for name, wires in rover.backends["raspberrypi"].items() if name != "eye"}
        devices = tuple(device for device in rover.devices if device.name != "eye")
        return rover.model_copy(update={"devices": devices, "backends": {"raspberrypi": wiring}})

    @pytest.fixture(autouse=True)
    def _use_mock_pins(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.gate = Gate()
        monkeypatch.setattr(backend, "open_pins", lambda: ModulePins(self.gate))

    def open_gated(self, setup: Setup, gate: Gate) -> Robot:
        self.gate = gate
        return self.open(setup)


class ModulePins(VirtualPins):
    """Mock pins in real time, with an ultrasonic module in front of a wall. A gate can block reads of its inputs."""

    def __init__(self, gate: Gate) -> None:
        super().__init__(MonotonicClock())
        self.gate = gate
        self.pin_class = GatedPin
        VirtualEcho(self._clock, FakeRange(0.7), self.pin(16), self.pin(26), speed_of_sound(20.0), lambda: False)

    def close(self) -> None:
        super().close()
        self._clock.close()


class GatedPin(VirtualPin):
    """A pin whose reads as an input wait while the gate is closed. An output has its state in a register."""

    def _get_state(self) -> Any:
        if self.function == "input":
            self._factory.gate.pass_through()
        return super()._get_state()
