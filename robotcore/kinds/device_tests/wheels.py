"""Tests motors and encoders: which wheel each of them is on, and its direction."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from robotcore.hal.device_tester import REVERSED, DeviceTester, Question
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


def test_motors(tester: DeviceTester, motors: Sequence[Any]) -> None:
    """Turn each motor for a moment, and find out which wheel turns and which encoder counts, and in which direction."""
    pulses = [_turn(tester, motor) for motor in motors]
    _judge_motors(tester, pulses)
    _judge_encoders(tester, pulses)


def test_encoders(tester: DeviceTester, encoders: Sequence[Any]) -> None:
    """Let the person turn the wheels of encoders by hand. Encoders on a wheel with an open motor are tested with it."""
    by_device = tester.description.drive.motor_by_device if tester.description.drive else {}
    for encoder in encoders:
        if by_device.get(encoder.name) in tester.robot.devices:
            continue
        before = _read_angles(tester)
        if not tester.instruct(
            encoder.name, "turn", f"Press Enter, and then turn the wheel of {encoder.name} forward by hand"
        ):
            tester.skip(encoder.name, "no motor is open that turns its wheel")
            continue
        tester.wait(2 * PULSE_S)
        turned, direction = _find_turned(tester, before)
        if turned == encoder.name and direction > 0:
            tester.confirm(encoder.name, "counts forward")
        elif turned == encoder.name:
            _report_reversed_encoder(tester, encoder.name)
        else:
            other = f", but {turned} does" if turned else ""
            text = f"does not count when its wheel turns{other}"
            tester.fail(encoder.name, text, "Check its wires, its supply and its pins", "encoder-dead")


def _turn(tester: DeviceTester, motor: Any) -> _Pulse:
    device: Any = tester.robot[motor.name]
    pulse = _Pulse(motor.name, None, 0, is_seen=False, encoder=None, encoder_direction=0)
    for share in SPEEDS:
        angles, true = _read_angles(tester), tester.state.measure_wheel_angles() if tester.state else {}
        tester.repeat(partial(device.set_velocity, share * motor.max_velocity_rad_s), PULSE_S)
        device.stop()
        tester.wait(SETTLE_S)
        encoder, encoder_direction = _find_turned(tester, angles)
        question = _build_question(tester, motor.name, true)
        answer = tester.ask(motor.name, question)
        pulse = _Pulse(
            motor.name,
            *_parse_answer(tester, motor.name, answer),
            is_seen=answer is not None,
            encoder=encoder,
            encoder_direction=encoder_direction,
        )
        if pulse.direction or (answer is None and _has_turned(tester, angles)):
            break
    return pulse


def _build_question(tester: DeviceTester, motor: str, before: Mapping[str, float]) -> Question:
    labels = _name_wheels(tester, motor)
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


def _name_wheels(tester: DeviceTester, motor: str) -> dict[str, tuple[str, str]]:
    """Return what the person types, and the place, of the wheels of each motor of the drive, by the motor.

    A motor that is on no wheel of the drive has only itself.
    """
    drive = tester.description.drive
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


def _parse_answer(tester: DeviceTester, motor: str, answer: object) -> tuple[str | None, int]:
    if not isinstance(answer, str) or answer == NONE:
        return None, 0
    key, sign = answer[:-1], answer[-1]
    wheel = next(name for name, (typed, _) in _name_wheels(tester, motor).items() if typed == key)
    return wheel, 1 if sign == "f" else -1


def _read_angles(tester: DeviceTester) -> dict[str, float]:
    encoders = tester.description.all_of("encoder")
    opened: dict[str, Any] = {each.name: tester.robot.devices.get(each.name) for each in encoders}
    return {name: device.read().angle for name, device in opened.items() if device}


def _find_turned(tester: DeviceTester, before: Mapping[str, float]) -> tuple[str | None, int]:
    """Return the only encoder that has turned, and its direction; None and 0 if none has turned, or several have."""
    turned = {name: angle - before[name] for name, angle in _read_angles(tester).items()}
    first, *others = [*sorted(turned, key=lambda name: -abs(turned[name])), ""]
    if not _list_turned(tester, turned) or abs(turned[first]) < DOMINANCE * abs(turned.get(others[0], 0.0)):
        return None, 0
    return first, 1 if turned[first] > 0 else -1


def _list_turned(tester: DeviceTester, turned: Mapping[str, float]) -> list[str]:
    """Return the encoders that have turned by more than their resolution."""
    counts = {each.name: each.counts_per_turn for each in tester.description.all_of("encoder")}
    return [name for name in turned if abs(turned[name]) > max(LEAST_RAD, LEAST_COUNTS * math.tau / counts[name])]


def _has_turned(tester: DeviceTester, before: Mapping[str, float]) -> bool:
    return bool(_list_turned(tester, {name: angle - before[name] for name, angle in _read_angles(tester).items()}))


def _judge_motors(tester: DeviceTester, pulses: Sequence[_Pulse]) -> None:
    source: dict[str, str] = {}
    for pulse in pulses:
        if pulse.wheel is None:
            _report_no_wheel(tester, pulse)
        elif pulse.wheel in source:
            text = f"turns the same wheel as {source[pulse.wheel]}"
            tester.fail(pulse.motor, text, "Give them different pins", "same-wheel")
        else:
            source[pulse.wheel] = pulse.motor
    swapped = _swap(tester, source, "{source} turns the wheel of {name}", "motor")
    for pulse in pulses:
        wheel = pulse.wheel
        if wheel is None or source[wheel] != pulse.motor or (wheel != pulse.motor and not swapped):
            continue
        if pulse.direction < 0:
            text = f"turns {'its' if wheel == pulse.motor else 'the'} wheel backward"
            remedy = "Swap the two wires of the motor"
            tester.correct(wheel, text, REVERSED, remedy=remedy, kind="motor-reversed")
        elif wheel == pulse.motor:
            tester.confirm(pulse.motor, "turns its wheel forward")


def _swap(tester: DeviceTester, source: Mapping[str, str], text: str, kind: str) -> bool:
    """Report devices that are connected in place of others. Return whether their wires could be swapped.

    source: the name of the device whose wires belong to each device.
    text: says what is wrong, with the names of both.
    """
    swapped = {name: other for name, other in source.items() if name != other}
    if set(swapped) == set(swapped.values()):
        if swapped:
            message = ", ".join(text.format(name=name, source=other) for name, other in swapped.items())
            tester.reconnect(swapped, message, remedy="Swap their wires", kind=f"{kind}s-swapped")
        return bool(swapped)
    for name, other in swapped.items():
        remedy = f"Correct the pins of {name} and {other}"
        tester.fail(other, text.format(name=name, source="it"), remedy, f"{kind}-on-other-wheel")
    return False


def _report_no_wheel(tester: DeviceTester, pulse: _Pulse) -> None:
    """Report a motor for which no person, and no truth, has named a wheel that turned."""
    if pulse.is_seen:
        text = f"turns no wheel, not even at {SPEEDS[-1]:.0%} of its greatest velocity"
        remedy = "Check the supply of the motor, its wires, its pins and the dead band of its model"
        tester.fail(pulse.motor, text, remedy, "motor-dead")
        return
    drive = tester.description.drive
    pairs = drive.motor_by_device.items() if drive else ()
    its = next((name for name, motor in pairs if motor == pulse.motor and name != motor), None)
    if pulse.encoder is None:
        tester.skip(pulse.motor, "no person has seen which wheel turned, and no single encoder has counted")
    elif pulse.encoder == its and pulse.encoder_direction > 0:
        tester.confirm(pulse.motor, f"turns the wheel of {its} forward; no person has confirmed the side and direction")
    else:
        back = " backward" if pulse.encoder_direction < 0 else ""
        text = f"{pulse.encoder} counted{back}, and no person has seen which wheel turned"
        tester.warn(pulse.motor, text, "Run the command in a terminal, and answer its questions", "motor-unconfirmed")


def _judge_encoders(tester: DeviceTester, pulses: Sequence[_Pulse]) -> None:
    if (drive := tester.description.drive) is None:
        return
    pulsed = {pulse.motor for pulse in pulses}
    own = {drive.motor_by_device[name]: name for name in drive.encoders if name in tester.robot.devices}
    own = {motor: name for motor, name in own.items() if motor in pulsed}
    turned = {own[pulse.wheel]: pulse for pulse in reversed(pulses) if pulse.wheel in own}
    source = {name: pulse.encoder for name, pulse in turned.items() if pulse.encoder}
    swapped = _swap(tester, source, "{source} is on the wheel of {name}", "encoder")
    counted = {pulse.encoder for pulse in pulses}
    for name in own.values():
        pulse = turned.get(name)
        if pulse is None:
            reason = "no person has seen its wheel turn" if name in counted else "its wheel did not turn alone"
            tester.skip(name, reason)
        elif name not in source:
            if name not in counted:
                remedy = "Check its supply, its wires, its pins, and whether its disc turns with the wheel"
                tester.fail(name, "counts nothing when its wheel turns", remedy, "encoder-dead")
        elif source[name] == name or swapped:
            is_right = pulse.encoder_direction == pulse.direction or not tester.has_own_direction(name)
            if not is_right:
                _report_reversed_encoder(tester, name)
            elif source[name] == name:
                tester.confirm(name, "counts in the direction of its wheel")


def _report_reversed_encoder(tester: DeviceTester, name: str) -> None:
    remedy = "Swap the wires of its two channels"
    tester.correct(name, "counts against the direction of its wheel", REVERSED, remedy=remedy, kind="encoder-reversed")
