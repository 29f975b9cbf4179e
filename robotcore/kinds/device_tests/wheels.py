"""Tests motors and encoders: which wheel each of them is on, and its direction."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from robotcore.hal.device_test import REVERSED, DeviceTest, Question
from robotcore.hal.simulation_state import SimulationState

SPEEDS = (0.2, 0.4, 0.8)
"""The velocities of the pulses, as shares of the motor's greatest. A faster one follows only if no wheel turned."""

PULSE_S, SETTLE_S = 0.6, 0.3
"""The duration of a pulse, and the pause after it, in seconds."""

LEAST_COUNTS, LEAST_RAD = 1.5, 0.05
"""An encoder has turned if its angle has changed by this many counts, and by at least this angle in radians."""

DOMINANCE = 3.0
"""An encoder is on the wheel that turned if it has turned this many times as far as each other one."""

NONE = "n"
"""The answer that no wheel turned."""


@dataclass(frozen=True)
class _Pulse:
    """What happened in a pulse of a motor."""

    motor: str
    wheel: str | None
    """The motor in the robot's file that belongs on the wheel that turned; None if none turned or it is unknown."""
    direction: int
    """1 if the wheel turned forward, -1 if backward, 0 if none turned or it is unknown."""
    is_seen: bool
    """Whether the person, or the truth of a simulator, has answered."""
    encoder: str | None
    """The encoder that turned; None if none did, or several."""
    encoder_direction: int
    """1 if the encoder turned forward, -1 if backward."""


def test_motors(test: DeviceTest, motors: Sequence[Any]) -> None:
    """Turn each motor for a moment, and find out which wheel turns and which encoder counts, and in which direction."""
    pulses = [_turn(test, motor) for motor in motors]
    _report_motors(test, pulses)
    _report_encoders(test, pulses)


def test_encoders(test: DeviceTest, encoders: Sequence[Any]) -> None:
    """Let the person turn the wheels of encoders by hand. Encoders on a wheel with an open motor are tested with it."""
    by_device = test.description.drive.motor_by_device if test.description.drive else {}
    for encoder in encoders:
        if by_device.get(encoder.name) in test.robot.devices:
            continue
        before = _read_angles(test)
        if not test.instruct(
            encoder.name, "turn", f"Press Enter, and then turn the wheel of {encoder.name} forward by hand"
        ):
            test.skip(encoder.name, "no motor is open that turns its wheel")
            continue
        test.wait(2 * PULSE_S)
        turned, direction = _find_turned(test, before)
        if turned == encoder.name and direction > 0:
            test.confirm(encoder.name, "counts forward")
        elif turned == encoder.name:
            _report_reversed_encoder(test, encoder.name)
        else:
            other = f", but {turned} does" if turned else ""
            text = f"does not count when its wheel turns{other}"
            test.fail(encoder.name, text, "Check its wires, its supply and its pins", "encoder-dead")


def _turn(test: DeviceTest, motor: Any) -> _Pulse:
    device: Any = test.robot[motor.name]
    pulse = _Pulse(motor.name, None, 0, is_seen=False, encoder=None, encoder_direction=0)
    for share in SPEEDS:
        angles, true = _read_angles(test), test.state.measure_wheel_angles() if test.state else {}
        test.repeat(partial(device.set_velocity, share * motor.max_velocity_rad_s), PULSE_S)
        device.stop()
        test.wait(SETTLE_S)
        encoder, encoder_direction = _find_turned(test, angles)
        question = _build_question(test, motor.name, true)
        answer = test.ask(motor.name, question)
        pulse = _Pulse(
            motor.name,
            *_parse_answer(test, motor.name, answer),
            is_seen=answer is not None,
            encoder=encoder,
            encoder_direction=encoder_direction,
        )
        if pulse.direction or (answer is None and _has_turned(test, angles)):
            break
    return pulse


def _build_question(test: DeviceTest, motor: str, before: Mapping[str, float]) -> Question:
    labels = _name_wheels(test, motor)
    signs = (("f", "forward"), ("b", "backward"))
    choices = {f"{key}{sign}": f"{label} {word}" for key, label in labels.values() for sign, word in signs}

    def answer(state: SimulationState) -> str | None:
        turned = {name: angle - before[name] for name, angle in state.measure_wheel_angles().items() if name in before}
        first, *others = [*sorted(turned, key=lambda name: -abs(turned[name])), ""]
        if not first or abs(turned[first]) < LEAST_RAD:
            return NONE
        if first not in labels or abs(turned[first]) < DOMINANCE * abs(turned.get(others[0], 0.0)):
            return None  # on the floor, the wheels of a robot that steers turn together
        return f"{labels[first][0]}{'f' if turned[first] > 0 else 'b'}"

    text = f"{motor} got a pulse forward. Which wheel turned, and in which direction would the robot have driven?"
    return Question("wheel", text, {**choices, NONE: "no wheel turned"}, answer)


def _name_wheels(test: DeviceTest, motor: str) -> dict[str, tuple[str, str]]:
    """Return what the person types, and the place, of the wheels of each motor of the drive, by the motor.

    A motor that is on no wheel of the drive has only itself.
    """
    drive = test.description.drive
    if drive is None or motor not in drive.motors:
        return {motor: ("", motor)}
    xs = [wheel.x_m for wheel in drive.wheels if wheel.motor]
    named = {}
    for name in drive.motors:
        wheels = drive.find_wheels(name)
        x, y = (sum(values) / len(wheels) for values in zip(*((each.x_m, each.y_m) for each in wheels), strict=True))
        parts = [] if min(xs) == max(xs) else ["front" if x > sum(xs) / len(xs) else "rear"]
        parts += [] if y == 0 else ["left" if y > 0 else "right"]
        words = parts or ["wheels"]
        named[name] = "".join(word[0] for word in words), " ".join(words)
    return named


def _parse_answer(test: DeviceTest, motor: str, answer: object) -> tuple[str | None, int]:
    if not isinstance(answer, str) or answer == NONE:
        return None, 0
    key, sign = answer[:-1], answer[-1]
    wheel = next(name for name, (typed, _) in _name_wheels(test, motor).items() if typed == key)
    return wheel, 1 if sign == "f" else -1


def _read_angles(test: DeviceTest) -> dict[str, float]:
    encoders = test.description.all_of("encoder")
    opened: dict[str, Any] = {each.name: test.robot.devices.get(each.name) for each in encoders}
    return {name: device.read().angle for name, device in opened.items() if device}


def _find_turned(test: DeviceTest, before: Mapping[str, float]) -> tuple[str | None, int]:
    """Return the only encoder that has turned, and its direction; None and 0 if none has turned, or several have."""
    turned = {name: angle - before[name] for name, angle in _read_angles(test).items()}
    first, *others = [*sorted(turned, key=lambda name: -abs(turned[name])), ""]
    if not _list_turned(test, turned) or abs(turned[first]) < DOMINANCE * abs(turned.get(others[0], 0.0)):
        return None, 0
    return first, 1 if turned[first] > 0 else -1


def _list_turned(test: DeviceTest, turned: Mapping[str, float]) -> list[str]:
    """Return the encoders that have turned by more than their resolution."""
    counts = {each.name: each.counts_per_turn for each in test.description.all_of("encoder")}
    return [name for name in turned if abs(turned[name]) > max(LEAST_RAD, LEAST_COUNTS * math.tau / counts[name])]


def _has_turned(test: DeviceTest, before: Mapping[str, float]) -> bool:
    return bool(_list_turned(test, {name: angle - before[name] for name, angle in _read_angles(test).items()}))


def _report_motors(test: DeviceTest, pulses: Sequence[_Pulse]) -> None:
    source: dict[str, str] = {}
    for pulse in pulses:
        if pulse.wheel is None:
            _report_no_wheel(test, pulse)
        elif pulse.wheel in source:
            text = f"turns the same wheel as {source[pulse.wheel]}"
            test.fail(pulse.motor, text, "Give them different pins", "same-wheel")
        else:
            source[pulse.wheel] = pulse.motor
    swapped = _swap(test, source, "{source} turns the wheel of {name}", "motor")
    for pulse in pulses:
        wheel = pulse.wheel
        if wheel is None or source[wheel] != pulse.motor or (wheel != pulse.motor and not swapped):
            continue
        if pulse.direction < 0:
            text = "turns its wheel backward" + (", after the swap" if wheel != pulse.motor else "")
            remedy = "Swap the two wires of the motor"
            test.correct(wheel, text, REVERSED, remedy=remedy, kind="motor-reversed")
        elif wheel == pulse.motor:
            test.confirm(pulse.motor, "turns its wheel forward")


def _swap(test: DeviceTest, source: Mapping[str, str], text: str, kind: str) -> bool:
    """Report devices that are connected in place of others. Return whether their wires could be swapped.

    source: the name of the device whose wires belong to each device.
    text: says what is wrong, with the names of both.
    """
    swapped = {name: other for name, other in source.items() if name != other}
    if set(swapped) == set(swapped.values()):
        if swapped:
            message = ", ".join(text.format(name=name, source=other) for name, other in swapped.items())
            test.swap_tables(swapped, message, remedy="Swap their wires", kind=f"{kind}s-swapped")
        return bool(swapped)
    for name, other in swapped.items():
        remedy = f"Correct the pins of {name} and {other}"
        test.fail(other, text.format(name=name, source="it"), remedy, f"{kind}-on-other-wheel")
    return False


def _report_no_wheel(test: DeviceTest, pulse: _Pulse) -> None:
    """Report a motor for which no person, and no truth, has named a wheel that turned."""
    if pulse.is_seen:
        text = f"turns no wheel, not even at {SPEEDS[-1]:.0%} of its greatest velocity"
        remedy = "Check the supply of the motor, its wires, its pins and the dead band of its model"
        test.fail(pulse.motor, text, remedy, "motor-dead")
        return
    drive = test.description.drive
    pairs = drive.motor_by_device.items() if drive else ()
    its = next((name for name, motor in pairs if motor == pulse.motor and name != motor), None)
    if pulse.encoder is None:
        test.skip(pulse.motor, "no person has seen which wheel turned, and no single encoder has counted")
    elif pulse.encoder == its and pulse.encoder_direction > 0:
        test.confirm(pulse.motor, f"turns the wheel of {its} forward; no person has confirmed the side and direction")
    else:
        back = " backward" if pulse.encoder_direction < 0 else ""
        text = f"{pulse.encoder} counted{back}, and no person has seen which wheel turned"
        test.warn(pulse.motor, text, "Run the command in a terminal, and answer its questions", "motor-unconfirmed")


def _report_encoders(test: DeviceTest, pulses: Sequence[_Pulse]) -> None:
    if (drive := test.description.drive) is None:
        return
    pulsed = {pulse.motor for pulse in pulses}
    own = {drive.motor_by_device[name]: name for name in drive.encoders if name in test.robot.devices}
    own = {motor: name for motor, name in own.items() if motor in pulsed}
    turned = {own[pulse.wheel]: pulse for pulse in reversed(pulses) if pulse.wheel in own}
    source = {name: pulse.encoder for name, pulse in turned.items() if pulse.encoder}
    swapped = _swap(test, source, "{source} is on the wheel of {name}", "encoder")
    counted = {pulse.encoder for pulse in pulses}
    for name in own.values():
        pulse = turned.get(name)
        if pulse is None:
            reason = "no person has seen its wheel turn" if name in counted else "its wheel did not turn alone"
            test.skip(name, reason)
        elif name not in source:
            if name not in counted:
                remedy = "Check its supply, its wires, its pins, and whether its disc turns with the wheel"
                test.fail(name, "counts nothing when its wheel turns", remedy, "encoder-dead")
        elif source[name] == name or swapped:
            is_right = pulse.encoder_direction == pulse.direction or not test.has_own_direction(name)
            if not is_right:
                _report_reversed_encoder(test, name)
            elif source[name] == name:
                test.confirm(name, "counts in the direction of its wheel")


def _report_reversed_encoder(test: DeviceTest, name: str) -> None:
    remedy = "Swap the wires of its two channels"
    test.correct(name, "counts against the direction of its wheel", REVERSED, remedy=remedy, kind="encoder-reversed")
