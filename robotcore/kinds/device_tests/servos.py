"""Tests servos: their direction, their angles and their limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from robotcore.hal.device_test import AT_OTHER_ANGLES, REVERSED, YES_OR_NO, DeviceTest, Question
from robotcore.hal.simulation_state import SimulationState

SHARES = (0.5, 0.25, 0.75)
"""The first commands, as shares of the range from the least to the greatest angle. They are far from both limits."""

INNER_SHARES = (0.5, 0.4, 0.6)
"""Commands nearer to the middle, for a servo that reaches a stop within its range."""

ENDS = (0.0, 1.0)

STEP_RAD_S = 0.5
"""The rate at which the command moves, in rad/s, so that a wrong angle moves nothing fast."""

SETTLE_S = 0.3
"""The time that a servo has to reach its angle after the last command, in seconds."""

MAX_ERROR_RAD = 0.09
"""The greatest error of an angle, in radians: 5 degrees. A person reads no angle more precisely."""

MAX_BEND_RAD, TRUE_BEND_RAD = 0.05, 0.005
"""If the angle in the middle differs by more from the mean of both others, the servo has reached a stop, in radians.

The first value is for angles that a person reads, the second for the truth of a simulator.
"""

STILL_RAD = 0.03
"""A servo whose angle differs by less between two commands does not turn, in radians."""


def test_servos(test: DeviceTest, servos: Sequence[Any]) -> None:
    """Turn each servo slowly, ask for its angles, and compare them with the commands."""
    for servo in servos:
        _test(test, servo)


def _test(test: DeviceTest, servo: Any) -> None:
    device: Any = test.robot[servo.name]
    start, span = device.angle, servo.max_angle_rad - servo.min_angle_rad
    points = _measure(test, device, servo, SHARES)
    if points and not _is_straight(points, TRUE_BEND_RAD if test.state else MAX_BEND_RAD):
        points = _measure(test, device, servo, INNER_SHARES)  # a stop of the servo bends the line
    if not points:
        test.skip(servo.name, "no person has measured its angles")
        _turn(test, device, start)
        return
    commands, angles = (np.array(column) for column in zip(*points, strict=True))
    if float(np.ptp(angles)) < STILL_RAD:
        text = "does not turn"
        test.fail(servo.name, text, "Check its supply, its wires and its pin", "servo-dead")
        _turn(test, device, start)
        return
    slope, offset = (float(each) for each in np.polyfit(commands, angles, 1))
    needed = [
        ((limit - offset) / slope - servo.min_angle_rad) / span for limit in (servo.min_angle_rad, servo.max_angle_rad)
    ]
    errors = np.abs(angles - commands)
    if slope < 0 and float(np.abs(angles + commands - servo.min_angle_rad - servo.max_angle_rad).max()) < MAX_ERROR_RAD:
        remedy = "Swap min_pulse_s and max_pulse_s"
        test.correct(servo.name, "turns the wrong way", REVERSED, remedy=remedy, kind="servo-reversed")
    elif float(errors.max()) > MAX_ERROR_RAD:
        listed = ", ".join(f"{math.degrees(b):.0f}° for {math.degrees(a):.0f}°" for a, b in points)
        remedy = "Correct min_pulse_s and max_pulse_s"
        text = f"turns to other angles: {listed}"
        test.correct(servo.name, text, AT_OTHER_ANGLES, needed, remedy=remedy, kind="servo-angles")
    elif not _test_ends(test, device, servo):
        test.confirm(servo.name, "turns to its angles, and positive to the left")
    _turn(test, device, start)


def _measure(test: DeviceTest, device: Any, servo: Any, shares: Sequence[float]) -> list[tuple[float, float]]:
    """Return commands and the angles that the servo shows, in radians; none if a person does not answer."""
    points = []
    for share in shares:
        command = servo.min_angle_rad + share * (servo.max_angle_rad - servo.min_angle_rad)
        _turn(test, device, command)
        if (angle := _ask_angle(test, servo.name, command)) is None:
            return []
        points.append((command, angle))
    return points


def _is_straight(points: Sequence[tuple[float, float]], limit: float) -> bool:
    """Return whether the angle in the middle is the mean of the two others, to within ``limit`` in radians."""
    (_, middle), (_, low), (_, high) = points
    return abs(middle - (low + high) / 2) < limit


def _test_ends(test: DeviceTest, device: Any, servo: Any) -> bool:
    """Turn a servo, whose angles are right, to its limits. Return whether one of them is beyond what it reaches."""
    reached = []
    for share in ENDS:
        limit = servo.min_angle_rad if share == 0 else servo.max_angle_rad
        _turn(test, device, limit)
        stops = partial(_stops_before, servo.name, limit)
        question = Question(
            f"end{share:g}", f"{servo.name} is at its limit. Does it hum, or push against a stop?", YES_OR_NO, stops
        )
        if test.ask(servo.name, question) == "y":
            angle = _ask_angle(test, servo.name, limit)
            if angle is not None and abs(angle - limit) > STILL_RAD:
                reached.append(("min_angle_rad" if share == 0 else "max_angle_rad", angle))
    for key, angle in reached:
        servo = _correct_limit(test, servo, key, angle)
    return bool(reached)


def _correct_limit(test: DeviceTest, servo: Any, key: str, angle: float) -> Any:
    """Report a limit that a servo does not reach, and return the servo's description with the corrected one.

    The pulses belong to the limits. So the limit stays as it is if no setting of the driver corrects the pulses.

    angle: the angle at which the servo stops, in radians.
    """
    share = (angle - servo.min_angle_rad) / (servo.max_angle_rad - servo.min_angle_rad)
    needed = [share, 1.0] if key == "min_angle_rad" else [0.0, share]
    limit = round(angle, 3)
    remedy = f"Set {key} to {limit:g}, and narrow the pulses"
    text = "its pulses turn it beyond its limit"
    is_corrected = test.correct(servo.name, text, AT_OTHER_ANGLES, needed, remedy=remedy, kind="servo-angles")
    text = f"stops at {math.degrees(angle):.0f}°, before its {key}"
    if not is_corrected:
        test.fail(servo.name, text, remedy, "servo-limit")
        return servo
    test.correct_description(servo.name, text, remedy=remedy, kind="servo-limit", **{key: limit})
    return servo.model_copy(update={key: limit})


def _turn(test: DeviceTest, device: Any, target: float) -> None:
    """Move the command slowly to an angle."""
    step = STEP_RAD_S / 20

    def approach() -> bool:
        away = target - device.angle
        device.set_angle(target if abs(away) <= step else device.angle + math.copysign(step, away))
        return bool(device.angle == target) or abs(away) < 1e-9

    test.wait_until(approach, 2 * abs(target - device.angle) / STEP_RAD_S + 1.0)
    test.wait(SETTLE_S)


def _ask_angle(test: DeviceTest, name: str, command: float) -> float | None:
    """Return the angle that the servo shows, in radians; None if it is unknown."""

    def answer(state: SimulationState) -> float:
        return math.degrees(state.joints[name].angle)

    text = f"What angle does {name} show, in degrees from straight ahead, positive to the left? "
    text += f"It should be {math.degrees(command):.0f}"
    shown = test.ask(name, Question(f"angle{math.degrees(command):.0f}", text, answer=answer))
    return None if shown is None else math.radians(float(shown))


def _stops_before(name: str, limit: float, state: SimulationState) -> str:
    return "y" if abs(state.joints[name].angle - limit) > STILL_RAD else "n"
