"""The commands of a recorded run to its wheels, in the order of time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from robotcore.fidelity.commands import find_impossible_command, integrate, list_servo_commands, list_wheel_commands
from robotcore.geometry import Wheels
from robotcore.recording import RecordedError, Tick
from robotcore.recording.events import ActuatorCommand
from robotcore.safety.velocity_limits import STOPPED, Intervention

FORWARD, TURN = Wheels(4.0, 4.0), Wheels(-2.0, 2.0)
BROKEN = RecordedError("DeviceError", "left_motor: no current")


def make_tick(number: int, sent: Wheels | None = None, **others: Any) -> Tick:
    return Tick(number, 10 + number / 20, "drive", sent=sent, **others)


def find_commands(*ticks: Tick) -> list[tuple[float, Wheels]]:
    return [(round(time, 9), wheels) for time, wheels in list_wheel_commands(ticks)]


def test_a_command_holds_from_its_tick_and_a_tick_without_one_changes_nothing() -> None:
    ticks = make_tick(0, FORWARD), make_tick(1), make_tick(2, TURN)
    assert find_commands(*ticks) == [(0.0, FORWARD), (0.1, TURN)]


def test_a_stop_between_two_ticks_takes_effect_at_its_own_time() -> None:
    deadman = Intervention(10.08, "deadman", FORWARD, STOPPED)
    late = make_tick(2, TURN, interventions=(deadman,))
    assert find_commands(make_tick(0, FORWARD), make_tick(1), late) == [(0.0, FORWARD), (0.08, STOPPED), (0.1, TURN)]


def test_a_stop_at_the_time_of_the_last_tick_comes_after_the_command_of_that_tick() -> None:
    lost = Intervention(10.0, "lost device", FORWARD, STOPPED)
    assert find_commands(make_tick(0, FORWARD), make_tick(1, interventions=(lost,)))[-1] == (0.0, STOPPED)


def test_a_rule_that_reduces_a_command_to_zero_is_no_other_stop() -> None:
    guard = Intervention(10.05, "range guard", FORWARD, STOPPED)
    ticks = make_tick(0, FORWARD), make_tick(1, TURN, interventions=(guard,))
    assert find_commands(*ticks) == [(0.0, FORWARD), (0.05, TURN)]


def test_a_stop_in_place_of_a_command_stops_the_wheels() -> None:
    pressed = Intervention(10.05, "e-stop", FORWARD, STOPPED)
    assert find_commands(make_tick(0, FORWARD), make_tick(1, interventions=(pressed,)))[-1] == (0.05, STOPPED)


@pytest.mark.parametrize("error", [{"error": BROKEN}, {"commit_error": BROKEN}], ids=["tick", "commit"])
def test_an_error_stops_the_wheels(error: dict[str, RecordedError]) -> None:
    assert find_commands(make_tick(0, FORWARD), make_tick(1, FORWARD, **error))[-1] == (0.05, STOPPED)


@pytest.mark.parametrize("invalid", [math.nan, math.inf, -101.0])
def test_a_velocity_that_no_robot_sends_is_found(invalid: float) -> None:
    ticks = [make_tick(0, FORWARD), make_tick(1, Wheels(1.0, invalid))]
    assert find_impossible_command(ticks, 100.0) is ticks[1]
    assert find_impossible_command([make_tick(1, Wheels(1.0, invalid), error=BROKEN)], 100.0) is None


def test_only_finite_angles_of_servos_are_repeated() -> None:
    given = (0.5, math.nan, None, "left", [0.1])
    asked = tuple(ActuatorCommand("pan", each, each) for each in given)
    ticks = [make_tick(0), make_tick(1, commands=(*asked, ActuatorCommand("lamp", 1.0, 1.0)))]
    (found,) = list_servo_commands(ticks, frozenset({"pan"}))
    assert (round(found.time, 9), found.servo, found.angle) == (0.05, "pan", 0.5)


def test_the_integral_of_commands_is_the_angle_that_they_turn() -> None:
    commands = list_wheel_commands([make_tick(0, FORWARD), make_tick(2, TURN), make_tick(4, STOPPED)])
    times = np.array([-0.1, 0.05, 0.1, 0.15, 0.3])
    expected = [(0.0, 0.0), (0.2, 0.2), (0.4, 0.4), (0.3, 0.5), (0.2, 0.6)]
    assert integrate(commands, times) == pytest.approx(np.array(expected))
