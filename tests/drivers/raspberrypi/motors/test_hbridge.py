from __future__ import annotations

import os
from contextlib import ExitStack
from typing import Any

import pytest
from gpiozero import OutputDevice
from gpiozero.exc import PinInvalidState
from gpiozero.pins.mock import MockFactory, MockPWMPin

from drivers.raspberrypi.motors.boards import HBridge
from drivers.raspberrypi.motors.driver import open_pwm_output
from robotcore.errors import DescriptionError, DeviceError
from robotcore.hal.devices import Motor
from robotcore.hardware import Host, bind_devices, static_cutoffs
from tests.drivers.raspberrypi.motors.rig import BACKWARD, FORWARD, H_BRIDGE, MODEL, Rig, rover
from tests.texts import Raises

ENABLE, STANDBY = 12, 22


class FailingPin(MockPWMPin):  # type: ignore[misc]  # gpiozero has no types
    """A pin whose writes raise an error if a test requests it."""

    is_broken = False

    def _set_state(self, value: float) -> None:
        if self.is_broken:
            raise PinInvalidState("not today")
        super()._set_state(value)


@pytest.mark.parametrize(
    "velocity, forward, backward",
    [(7.0, 0.55, 0), (-7.0, 0, 0.55), (0.0, 0, 0), (100.0, 0.87, 0), (0.001, 0.1, 0)],
)
def test_a_velocity_is_a_duty_on_the_pin_of_its_direction(velocity: float, forward: float, backward: float) -> None:
    rig = Rig()
    rig.motor.set_velocity(velocity)
    assert levels(rig) == pytest.approx((forward, backward))


def test_a_change_of_direction_sets_the_first_pin_low() -> None:
    rig = Rig()
    rig.motor.set_velocity(7.0)
    rig.motor.set_velocity(-7.0)
    assert levels(rig) == pytest.approx((0, 0.55))
    rig.motor.set_velocity(7.0)
    assert levels(rig) == pytest.approx((0.55, 0))


def test_the_limit_is_the_description_s() -> None:
    assert Rig().motor.set_velocity(100.0) == 12.0


def test_each_direction_has_a_duty_of_its_own() -> None:
    rig = Rig({**H_BRIDGE, "model": {**MODEL, "backward_rad_s": 12.6}})
    rig.motor.set_velocity(-12.6 / 2)
    assert levels(rig) == pytest.approx((0, 0.55))


def test_stopping_pulls_both_low() -> None:
    rig = Rig()
    rig.motor.set_velocity(7.0)
    rig.motor.stop()
    assert levels(rig) == (0, 0)


@pytest.mark.parametrize("velocity", [7.0, -7.0, 0.0])
def test_a_command_like_the_last_is_sent_again(velocity: float) -> None:
    rig = Rig()
    rig.motor.set_velocity(velocity)
    sent = levels(rig)
    for number in (FORWARD, BACKWARD):
        rig.pins.pin(number).state = 0.33  # another process has changed the line meanwhile
    rig.motor.set_velocity(velocity)
    assert levels(rig) == sent


def test_pulses_have_the_frequency_of_the_settings() -> None:
    rig = Rig({**H_BRIDGE, "frequency_hz": 1000})
    assert [rig.pins.pin(number).frequency for number in (FORWARD, BACKWARD)] == [1000, 1000]


def test_opening_turns_no_motor() -> None:
    rig = Rig()
    assert levels(rig) == (0, 0)


def test_an_enable_line_is_high_while_the_motor_is_open() -> None:
    rig = Rig({**H_BRIDGE, "enable": ENABLE})
    pin = rig.pins.pin(ENABLE)
    assert (pin.function, pin.state) == ("output", 1)
    rig.motor.stop()
    assert pin.state == 1
    rig.close()
    assert pin.function == "input"


def test_the_standby_line_is_left_to_the_guardian() -> None:
    rig = Rig({**H_BRIDGE, "standby": STANDBY})
    OutputDevice(STANDBY, pin_factory=rig.pins).close()


def test_closing_stops_the_motor_and_frees_every_pin() -> None:
    rig = Rig({**H_BRIDGE, "enable": ENABLE})
    rig.motor.set_velocity(7.0)
    rig.close()
    for number in (FORWARD, BACKWARD, ENABLE):
        assert rig.pins.pin(number).state == 0
        OutputDevice(number, pin_factory=rig.pins).close()


def test_closed_lines_are_pulled_down() -> None:
    rig = Rig({**H_BRIDGE, "enable": ENABLE})
    rig.close()
    assert [rig.pins.pin(number).pull for number in (FORWARD, BACKWARD, ENABLE)] == ["down"] * 3


def test_a_line_with_a_fixed_pull_up_can_be_closed() -> None:
    pins = MockFactory(pin_class=MockPWMPin)
    with ExitStack() as opened:
        open_pwm_output("left_motor", 2, 100, pins, opened)
    OutputDevice(2, pin_factory=pins).close()


@pytest.mark.parametrize("lines", [{"forward": 2}, {"backward": 3}, {"enable": 2}, {"standby": 3}])
def test_a_line_that_a_resistor_holds_high_is_refused(lines: dict[str, int], raises: Raises) -> None:
    with raises(DescriptionError):
        bind_devices(rover({"left_motor": {**H_BRIDGE, **lines}}), "raspberrypi", ["left_motor"])


@pytest.mark.parametrize(
    "lines, is_noted",
    [
        ({}, False),
        ({"forward": 9}, False),
        ({"forward": 8}, True),
        ({"standby": 4}, True),
        ({"forward": 8, "standby": 22}, False),
    ],
)
def test_a_line_that_is_pulled_up_while_the_pi_starts_has_a_warning(lines: dict[str, int], is_noted: bool) -> None:
    (binding,) = bind_devices(rover({"left_motor": {**H_BRIDGE, **lines}}), "raspberrypi", ["left_motor"])
    assert any("are pulled up" in note for note in binding.notes) is is_noted
    assert bool(binding.warnings) is is_noted


@pytest.mark.parametrize("broken, other", [(FORWARD, BACKWARD), (BACKWARD, FORWARD)])
@pytest.mark.parametrize("leave", [Motor.stop, Motor.close])
def test_a_pin_that_fails_does_not_keep_the_other_high(broken: int, other: int, leave: Any, raises: Raises) -> None:
    rig = Rig(pin_class=FailingPin)
    rig.motor.set_velocity(7.0 if other == FORWARD else -7.0)
    assert rig.pins.pin(other).state > 0
    rig.pins.pin(broken).is_broken = True
    with raises(DeviceError, "gpio-failed"):
        leave(rig.motor)
    assert rig.pins.pin(other).state == 0


def test_a_stop_that_fails_leaves_no_line_without_its_pwm(raises: Raises) -> None:
    rig = Rig(pin_class=FailingPin)
    rig.motor.set_velocity(7.0)
    rig.pins.pin(FORWARD).is_broken = True
    with raises(DeviceError, "gpio-failed"):
        rig.motor.stop()
    assert rig.pins.pin(FORWARD).frequency == 100


def test_a_line_that_cannot_be_pulled_down_is_reported_alone_and_once(raises: Raises) -> None:
    class Unpullable(MockPWMPin):  # type: ignore[misc]  # gpiozero has no types
        def _set_pull(self, value: str) -> None:
            if value == "down" and self.info.name == f"GPIO{BACKWARD}":
                raise OSError("bad handle")
            super()._set_pull(value)

    rig = Rig(pin_class=Unpullable)
    with raises(DeviceError, "gpio-failed"):
        rig.motor.close()
    assert rig.pins.pin(FORWARD).pull == "down"


def test_a_failure_while_turning_is_reported_with_a_remedy(raises: Raises) -> None:
    rig = Rig(pin_class=FailingPin)
    rig.pins.pin(BACKWARD).is_broken = True
    with raises(DeviceError, "gpio-failed") as raised:
        rig.motor.set_velocity(1.0)
    assert isinstance(raised.value.__cause__, PinInvalidState)
    assert rig.pins.pin(FORWARD).state == 0


@pytest.mark.parametrize("taken", [FORWARD, BACKWARD, ENABLE])
def test_a_pin_in_use_is_reported_and_the_others_are_freed(taken: int, raises: Raises) -> None:
    pins = MockFactory(pin_class=MockPWMPin)
    with OutputDevice(taken, pin_factory=pins):
        with raises(DeviceError, "gpio-in-use"):
            Rig({**H_BRIDGE, "enable": ENABLE}, pins=pins)
        for number in {FORWARD, BACKWARD, ENABLE} - {taken}:
            OutputDevice(number, pin_factory=pins).close()


def test_every_wire_has_its_gpio_and_standby_may_be_shared() -> None:
    section = {"left_motor": {**H_BRIDGE, "enable": ENABLE, "standby": STANDBY}}
    (binding,) = bind_devices(rover(section), "raspberrypi", ["left_motor"])
    wires = {wire.signal: (str(wire), wire.is_shared) for wire in binding.connections}
    assert wires == {
        "forward": ("GPIO 17", False),
        "backward": ("GPIO 27", False),
        "enable": ("GPIO 12", False),
        "standby": ("GPIO 22", True),
    }


@pytest.mark.parametrize("model", [{"forward_rad_s": 11.0}, {"backward_rad_s": 11.0}, {"max_duty": 0.5}])
def test_a_velocity_that_the_model_does_not_reach_is_refused(model: dict[str, float], raises: Raises) -> None:
    with raises(DescriptionError):
        Rig({**H_BRIDGE, "model": {**MODEL, **model}})


def test_a_motor_without_a_model_is_refused(raises: Raises) -> None:
    with raises(DescriptionError, "missing-key"):
        Rig({"driver": "h-bridge", "forward": FORWARD, "backward": BACKWARD})


def test_mock_pins_have_no_cutoffs() -> None:
    rig = Rig({**H_BRIDGE, "standby": STANDBY})
    assert rig.bindings["left_motor"].cutoffs(rig.host) == ()


def test_the_cutoff_is_the_standby_line_if_there_is_one() -> None:
    (spec,) = cutoffs({**H_BRIDGE, "standby": STANDBY})
    assert (spec.device, spec.cutoff) == ("left_motor", "drivers.raspberrypi.cutoff:StandbyLine")
    assert spec.parameters == {"line": STANDBY}
    spec.make()


def test_the_cutoff_is_the_motor_s_lines_without_a_standby_line() -> None:
    (spec,) = cutoffs({**H_BRIDGE, "enable": ENABLE})
    assert spec.cutoff == "drivers.raspberrypi.cutoff:MotorLines"
    assert spec.parameters == {"lines": [FORWARD, BACKWARD, ENABLE], "owner": os.getpid()}
    spec.make()


def test_the_cutoff_of_a_closed_motor_kills_no_process() -> None:
    robot = rover({"left_motor": {**H_BRIDGE, "enable": ENABLE}})
    (spec,) = static_cutoffs(robot, bind_devices(robot, "raspberrypi", ["left_motor"]))
    assert spec.parameters == {"lines": [FORWARD, BACKWARD, ENABLE], "owner": None}
    spec.make()


def test_the_driver_is_found_by_its_name() -> None:
    (binding,) = bind_devices(rover({"left_motor": H_BRIDGE}), "raspberrypi", ["left_motor"])
    assert isinstance(binding.driver, HBridge)


def cutoffs(section: dict[str, Any]) -> Any:
    robot = rover({"left_motor": section})
    (binding,) = bind_devices(robot, "raspberrypi", ["left_motor"])
    return binding.cutoffs(Host(robot, Rig().clock, pins=object()))


def levels(rig: Rig) -> tuple[float, float]:
    return rig.pins.pin(FORWARD).state, rig.pins.pin(BACKWARD).state
