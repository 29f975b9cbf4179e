from __future__ import annotations

from typing import Any

import pytest
from gpiozero import OutputDevice
from gpiozero.pins.mock import MockFactory, MockPWMPin

from robotcore.errors import DescriptionError, DeviceError
from robotcore.hardware import bind_devices
from tests.drivers.raspberrypi.motors.rig import MODEL, Rig, rover
from tests.texts import Raises

PHASE, ENABLE = 23, 24
PHASE_ENABLE = {"driver": "phase-enable", "phase": PHASE, "enable": ENABLE, "model": dict(MODEL)}


@pytest.mark.parametrize("velocity, phase, enable", [(7.0, 0, 0.55), (-7.0, 1, 0.55), (0.0, 0, 0)])
def test_a_velocity_is_a_duty_and_a_direction(velocity: float, phase: int, enable: float) -> None:
    rig = Rig(PHASE_ENABLE)
    rig.motor.set_velocity(velocity)
    assert levels(rig) == (phase, pytest.approx(enable))


def test_stopping_sets_the_duty_to_0() -> None:
    rig = Rig(PHASE_ENABLE)
    rig.motor.set_velocity(-7.0)
    rig.motor.stop()
    assert levels(rig)[1] == 0


def test_the_duty_is_0_while_the_direction_changes() -> None:
    rig = Rig(PHASE_ENABLE, pin_class=RecordingPin)
    rig.motor.set_velocity(7.0)
    sent = rig.pins.sent = []
    rig.motor.set_velocity(-7.0)
    assert sent == [(ENABLE, 0), (PHASE, 1), (ENABLE, pytest.approx(0.55))]


def test_a_command_like_the_last_is_sent_again_without_a_gap() -> None:
    rig = Rig(PHASE_ENABLE, pin_class=RecordingPin)
    rig.motor.set_velocity(-7.0)
    sent = rig.pins.sent = []
    rig.motor.set_velocity(-7.0)
    assert sent == [(PHASE, 1), (ENABLE, pytest.approx(0.55))]


def test_closing_stops_the_motor_and_frees_every_pin() -> None:
    rig = Rig(PHASE_ENABLE)
    rig.motor.set_velocity(-7.0)
    rig.close()
    assert levels(rig) == (0, 0)
    for number in (PHASE, ENABLE):
        OutputDevice(number, pin_factory=rig.pins).close()


@pytest.mark.parametrize("taken, other", [(PHASE, ENABLE), (ENABLE, PHASE)])
def test_a_pin_in_use_is_reported_and_the_other_is_freed(taken: int, other: int, raises: Raises) -> None:
    pins = MockFactory(pin_class=MockPWMPin)
    with OutputDevice(taken, pin_factory=pins):
        with raises(DeviceError, "gpio-in-use"):
            Rig(PHASE_ENABLE, pins=pins)
        OutputDevice(other, pin_factory=pins).close()


def test_every_wire_has_its_gpio() -> None:
    rig = Rig({**PHASE_ENABLE, "standby": 22})
    wires = {wire.signal: (wire.where, wire.is_shared) for wire in rig.bindings["left_motor"].connections}
    assert wires == {"phase": ("23", False), "enable": ("24", False), "standby": ("22", True)}


class RecordingPin(MockPWMPin):  # type: ignore[misc]  # gpiozero has no types
    """A pin that records every write in its factory."""

    def _set_state(self, value: float) -> None:
        super()._set_state(value)
        if hasattr(self.factory, "sent"):
            self.factory.sent.append((self.info.name and int(self.info.name.removeprefix("GPIO")), value))


def levels(rig: Rig) -> tuple[Any, Any]:
    return rig.pins.pin(PHASE).state, rig.pins.pin(ENABLE).state


def test_only_lines_that_turn_the_motor_must_not_be_held_high(raises: Raises) -> None:
    wires = {"driver": "phase-enable", "phase": 2, "enable": 17, "model": dict(MODEL)}
    assert bind_devices(rover({"left_motor": wires}), "raspberrypi", ["left_motor"])
    with raises(DescriptionError):
        bind_devices(rover({"left_motor": {**wires, "phase": 17, "enable": 2}}), "raspberrypi", ["left_motor"])
