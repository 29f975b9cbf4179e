"""Motor boards on mock pins and on simulated lines: levels, opening and closing, failures, cutoffs, and mistakes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import pytest
from gpiozero import OutputDevice
from gpiozero.exc import PinInvalidState
from gpiozero.pins.mock import MockFactory, MockPWMPin

from drivers.raspberrypi.backend import RaspberryPiBackend
from drivers.raspberrypi.motors.bridge import round_to_percent
from robotcore.description import RobotDescription, load_robot
from robotcore.errors import DescriptionError, DeviceError
from robotcore.hal.backend import Setup
from robotcore.hardware import DeviceContext, bind_devices
from robotcore.kinds.motor import Motor
from tests.drivers.raspberrypi.lines import Lines
from tests.drivers.raspberrypi.motors.rig import BACKWARD, FORWARD, H_BRIDGE, MODEL, Rig, rover
from tests.texts import Raises

PWM, ENABLE, STANDBY = 13, 12, 22
WITH_PWM = {**H_BRIDGE, "pwm": PWM}
PHASE_ENABLE = {"driver": "phase-enable", "phase": BACKWARD, "enable": FORWARD, "model": dict(MODEL)}

Board = Mapping[str, Any]
BOARDS = pytest.mark.parametrize("board", [H_BRIDGE, WITH_PWM, PHASE_ENABLE], ids=["two inputs", "pwm", "phase"])


class TestedPin(MockPWMPin):  # type: ignore[misc]  # gpiozero has no types
    """A pin that records its writes in its factory, and raises an error if it is broken."""

    __test__ = False
    is_broken = False

    def _set_state(self, value: float) -> None:
        if self.is_broken:
            raise PinInvalidState("not today")
        super()._set_state(value)
        if hasattr(self.factory, "sent"):
            self.factory.sent.append((int(self.info.name.removeprefix("GPIO")), round(float(value), 2)))


def lines_of(board: Board) -> list[int]:
    return [board[key] for key in ("forward", "backward", "pwm", "phase", "enable") if key in board]


def levels(rig: Rig, board: Board) -> dict[int, float]:
    """Return the levels of all lines that are not low."""
    found = {number: round(float(rig.pins.pin(number).state), 6) for number in lines_of(board)}
    return {number: level for number, level in found.items() if level}


@pytest.mark.parametrize(
    "board, velocity, high",
    [
        (H_BRIDGE, 7.0, {FORWARD: 0.55}),
        (H_BRIDGE, -7.0, {BACKWARD: 0.55}),
        (H_BRIDGE, 0.001, {FORWARD: 0.1}),
        (H_BRIDGE, 100.0, {FORWARD: 0.87}),
        (WITH_PWM, 7.0, {FORWARD: 1.0, PWM: 0.55}),
        (WITH_PWM, -7.0, {BACKWARD: 1.0, PWM: 0.55}),
        (PHASE_ENABLE, 7.0, {FORWARD: 0.55}),
        (PHASE_ENABLE, -7.0, {BACKWARD: 1.0, FORWARD: 0.55}),
    ],
)
def test_a_velocity_is_a_duty_and_a_direction_and_a_stop_is_low(
    board: Board, velocity: float, high: dict[int, float]
) -> None:
    rig = Rig(board)
    assert levels(rig, board) == {}
    rig.motor.set_velocity(velocity)
    assert levels(rig, board) == high
    rig.motor.stop()
    assert levels(rig, board) == {}


@pytest.mark.parametrize(
    "board, stopping, turning",
    [
        (H_BRIDGE, [(BACKWARD, 0), (FORWARD, 0)], [(FORWARD, 0), (BACKWARD, 0.55)]),
        (WITH_PWM, [(PWM, 0), (BACKWARD, 0), (FORWARD, 0)], [(FORWARD, 0), (BACKWARD, 1), (PWM, 0.55)]),
        (PHASE_ENABLE, [(FORWARD, 0), (BACKWARD, 0)], [(BACKWARD, 1), (FORWARD, 0.55)]),
    ],
)
def test_every_line_is_low_before_the_direction_changes_and_a_like_command_has_no_gap(
    board: Board, stopping: list[Any], turning: list[Any]
) -> None:
    rig = Rig(board, pin_class=TestedPin)
    rig.motor.set_velocity(7.0)
    sent = rig.pins.sent = []
    rig.motor.set_velocity(-7.0)
    assert sent == stopping + turning
    sent.clear()
    rig.motor.set_velocity(-7.0)
    assert sent == turning


@BOARDS
@pytest.mark.parametrize("velocity", [7.0, -7.0, 0.0])
def test_a_command_like_the_last_corrects_a_line_that_another_process_has_changed(
    board: Board, velocity: float
) -> None:
    rig = Rig(board)
    rig.motor.set_velocity(velocity)
    sent = levels(rig, board)
    for number in lines_of(board):
        rig.pins.pin(number).state = 0.33
    rig.motor.set_velocity(velocity)
    assert levels(rig, board) == sent


def test_an_enable_line_is_high_while_the_motor_is_open() -> None:
    rig = Rig({**H_BRIDGE, "enable": ENABLE})
    pin = rig.pins.pin(ENABLE)
    rig.motor.stop()
    assert (pin.function, pin.state) == ("output", 1)
    rig.close()
    assert (pin.function, pin.state) == ("input", 0)


@BOARDS
def test_closing_stops_the_motor_and_frees_every_line_with_a_pull_down(board: Board) -> None:
    board = {**board, "enable": board.get("enable", ENABLE)}
    rig = Rig(board)
    rig.motor.set_velocity(-7.0)
    rig.close()
    assert levels(rig, board) == {}
    for number in lines_of(board):
        assert rig.pins.pin(number).pull == "down"
        OutputDevice(number, pin_factory=rig.pins).close()


@BOARDS
@pytest.mark.parametrize("leave", [Motor.stop, Motor.close])
def test_a_line_that_fails_does_not_keep_another_high(board: Board, leave: Any, raises: Raises) -> None:
    for velocity in (7.0, -7.0):
        for broken in lines_of(board):
            rig = Rig(board, pin_class=TestedPin)
            rig.motor.set_velocity(velocity)
            rig.pins.pin(broken).is_broken = True
            with pytest.raises(DeviceError) as raised:
                leave(rig.motor)
            assert raised.value.kind == "gpio-failed"
            assert set(levels(rig, board)) <= {broken}


def test_a_stop_that_fails_leaves_no_line_without_its_pwm(raises: Raises) -> None:
    rig = Rig({**H_BRIDGE, "frequency_hz": 1000}, pin_class=TestedPin)
    rig.motor.set_velocity(7.0)
    rig.pins.pin(FORWARD).is_broken = True
    with raises(DeviceError, "gpio-failed"):
        rig.motor.stop()
    assert rig.pins.pin(FORWARD).frequency == 1000


def test_a_line_that_cannot_be_pulled_down_is_reported_and_the_other_is_pulled_down(raises: Raises) -> None:
    class Unpullable(MockPWMPin):  # type: ignore[misc]  # gpiozero has no types
        def _set_pull(self, value: str) -> None:
            if value == "down" and self.info.name == f"GPIO{BACKWARD}":
                raise OSError("bad handle")
            super()._set_pull(value)

    rig = Rig(pin_class=Unpullable)
    with raises(DeviceError, "gpio-failed"):
        rig.motor.close()
    assert rig.pins.pin(FORWARD).pull == "down"


@pytest.mark.parametrize("board", [{**WITH_PWM, "enable": ENABLE}, PHASE_ENABLE], ids=["h-bridge", "phase"])
def test_a_line_in_use_is_reported_and_the_others_are_freed(board: Board) -> None:
    for taken in lines_of(board):
        pins = MockFactory(pin_class=MockPWMPin)
        with OutputDevice(taken, pin_factory=pins):
            with pytest.raises(DeviceError) as raised:
                Rig(board, pins=pins)
            assert (raised.value.kind, raised.value.fields["gpios"]) == ("gpio-in-use", (taken,))
            for number in set(lines_of(board)) - {taken}:
                OutputDevice(number, pin_factory=pins).close()


@BOARDS
def test_on_lgpio_a_stop_is_low_at_once_and_the_next_command_turns_again(board: Board, lines: Lines, pins: Any) -> None:
    """In the double of lgpio, a line never falls after the duty 0, as in a process that is suspended then."""
    motor = Rig(board, pins=pins, names=("left_motor",)).motor
    for velocity in (7.0, 7.0, -7.0):
        motor.set_velocity(velocity)
        assert 55 in {lines.level(number) for number in lines_of(board)}
        motor.stop()
        assert {lines.level(number) for number in lines_of(board)} == {0}
    motor.close()


def send_duties(rig: Rig, velocity: float, count: int) -> list[float]:
    """Command a velocity several times, and return the duty on the forward line after each command."""
    sent = []
    for _ in range(count):
        rig.motor.set_velocity(velocity)
        sent.append(float(rig.pins.pin(FORWARD).state))
    return sent


@pytest.mark.parametrize("duty", [0.3025, 0.505, 0.7175])
def test_the_mean_of_many_duties_is_exact_although_each_is_a_whole_percent(duty: float) -> None:
    sent = send_duties(Rig(H_BRIDGE), 14 * (duty - 0.1) / 0.9, 40)
    assert sum(sent) / 40 == pytest.approx(duty, abs=1e-3)
    assert {round(100 * each, 6) % 1 for each in sent} == {0.0}
    assert max(sent) - min(sent) <= 0.0101


def test_after_a_stop_and_a_change_of_direction_nothing_is_left_over_of_the_last_duty() -> None:
    rig, velocity = Rig(H_BRIDGE), 14 * (0.3049 - 0.1) / 0.9
    first = send_duties(rig, velocity, 1)
    rig.motor.stop()
    assert send_duties(rig, velocity, 1) == first
    rig.motor.set_velocity(-velocity)
    assert send_duties(rig, velocity, 1) == first


def test_the_greatest_duty_stays_the_greatest() -> None:
    assert set(send_duties(Rig({**H_BRIDGE, "model": {**MODEL, "forward_rad_s": 12.0}}), 12.0, 5)) == {1.0}


def test_lgpio_sends_exactly_the_whole_percent() -> None:
    for percent in range(-100, 101):
        duty = round_to_percent(percent / 100)
        assert int(duty * 100) == percent
        assert duty == pytest.approx(percent / 100), percent
        assert abs(duty) <= 1, percent


@pytest.mark.parametrize(
    "board, cutoff, parameters",
    [
        ({**WITH_PWM, "standby": STANDBY}, "StandbyLine", {"line": STANDBY}),
        ({**H_BRIDGE, "enable": ENABLE}, "MotorLines", {"lines": [FORWARD, BACKWARD, ENABLE]}),
        (WITH_PWM, "MotorLines", {"lines": [FORWARD, BACKWARD, PWM]}),
        (PHASE_ENABLE, "MotorLines", {"lines": [FORWARD, BACKWARD]}),
    ],
)
def test_the_cutoff_is_the_standby_line_or_all_lines_and_without_a_run_it_kills_no_process(
    board: Board, cutoff: str, parameters: dict[str, Any]
) -> None:
    robot = rover({"left_motor": board})
    (binding,) = bind_devices(robot, "raspberrypi", ["left_motor"])
    (opened,) = binding.driver.cutoffs(binding.description, DeviceContext(robot, Rig().clock, pins=object()))
    (static,) = RaspberryPiBackend().cutoffs(Setup(robot, None, frozenset({"left_motor"})))
    for spec, owner in ((opened, os.getpid()), (static, None)):
        assert (spec.device, spec.cutoff) == ("left_motor", f"drivers.raspberrypi.cutoff:{cutoff}")
        assert spec.parameters == parameters | ({"owner": owner} if "lines" in parameters else {})
        spec.make()


def test_mock_pins_have_no_cutoffs() -> None:
    rig = Rig({**H_BRIDGE, "standby": STANDBY})
    binding = rig.bindings["left_motor"]
    assert binding.driver.cutoffs(binding.description, rig.host) == ()


@pytest.mark.parametrize(
    "board, wires",
    [
        ({**WITH_PWM, "enable": ENABLE, "standby": STANDBY}, "forward 17, backward 27, pwm 13, enable 12, standby 22"),
        ({**PHASE_ENABLE, "standby": STANDBY}, "enable 17, phase 27, standby 22"),
    ],
)
def test_every_wire_has_its_gpio_and_only_standby_may_be_shared(board: Board, wires: str) -> None:
    (binding,) = bind_devices(rover({"left_motor": board}), "raspberrypi", ["left_motor"])
    assert ", ".join(f"{wire.signal} {wire.where}" for wire in binding.driver.connections()) == wires
    assert [wire.signal for wire in binding.driver.connections() if wire.is_shared] == ["standby"]


def bind(**sections: Board) -> RobotDescription:
    """Bind the rover with these tables, and return it."""
    shipped = load_robot("rover")
    robot = shipped.model_copy(update={"backends": {"raspberrypi": {**shipped.backends["raspberrypi"], **sections}}})
    bind_devices(robot, "raspberrypi")
    return robot


@pytest.mark.parametrize(
    "board, is_warned",
    [
        ({**H_BRIDGE, "forward": 9}, False),
        ({**H_BRIDGE, "forward": 8}, True),
        ({**H_BRIDGE, "forward": 14}, True),
        ({**H_BRIDGE, "standby": 4}, True),
        ({**H_BRIDGE, "forward": 8, "standby": 22}, False),
        ({**WITH_PWM, "forward": 8}, False),
        ({**WITH_PWM, "pwm": 8}, True),
        ({**PHASE_ENABLE, "phase": 2}, False),
    ],
)
def test_a_line_that_is_pulled_up_and_turns_the_motor_while_the_pi_starts_has_a_warning(
    board: Board, is_warned: bool
) -> None:
    assert bool(RaspberryPiBackend().warnings(bind(left_motor=board))) is is_warned


@pytest.mark.parametrize(
    "board, key, kind",
    [
        ({**H_BRIDGE, "forward": 2}, "", "setting-conflict"),
        ({**H_BRIDGE, "enable": 2}, "", "setting-conflict"),
        ({**H_BRIDGE, "standby": 3}, "", "setting-conflict"),
        ({**WITH_PWM, "pwm": 3}, "", "setting-conflict"),
        ({**PHASE_ENABLE, "enable": 2}, "", "setting-conflict"),
        ({**H_BRIDGE, "model": {**MODEL, "forward_rad_s": 11.0}}, "", "setting-conflict"),
        ({**H_BRIDGE, "model": {**MODEL, "max_duty": 0.5}}, "", "setting-conflict"),
        ({**H_BRIDGE, "frequency_hz": 50, "control": {"period_s": 0.01}}, "", "setting-conflict"),
        ({**H_BRIDGE, "model": {**MODEL, "dead_bnd": 0.1}}, ".model.dead_bnd", "unknown-key"),
        ({"driver": "h-bridge", "forward": 17, "backward": 27}, ".model", "missing-key"),
        ({**WITH_PWM, "pwm": FORWARD}, ".pwm", "pin-conflict"),
    ],
)
def test_a_mistake_in_a_motors_table_is_reported_with_its_key(
    board: Board, key: str, kind: str, raises: Raises
) -> None:
    with raises(DescriptionError, kind, key=f"raspberrypi.left_motor{key}"):
        bind(left_motor=board)


def test_an_enable_line_of_two_motors_may_be_their_standby(raises: Raises) -> None:
    left = {**H_BRIDGE, "enable": 22}
    with raises(DescriptionError, "pin-conflict", key="raspberrypi.right_motor.enable"):
        bind(left_motor=left, right_motor={**left, "forward": 23, "backward": 24})
