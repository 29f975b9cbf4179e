from __future__ import annotations

from typing import Any

import pytest

from drivers.raspberrypi.loopback.wires import LoopbackWire, choose_wires, find_problem, find_used_gpios
from robotcore.description import load_robot
from robotcore.errors import UsageError
from robotcore.hardware import bind_devices
from tests.drivers.raspberrypi.lines import Lines
from tests.drivers.raspberrypi.loopback.conftest import WIRES
from tests.texts import CheckText, Raises


def test_the_default_pins_are_none_of_the_robots() -> None:
    used = find_used_gpios(bind_devices(load_robot("rover"), "raspberrypi"))
    chosen = {gpio for wire in choose_wires((), used) for gpio in (wire.output, wire.input)}
    assert len(chosen) == 4
    assert not chosen & set(used)


def test_without_a_robot_the_wires_connect_neighbouring_pads() -> None:
    assert [str(wire) for wire in choose_wires((), {})] == [
        "wire 1 from GPIO 20 (pad 38) to GPIO 21 (pad 40)",
        "wire 2 from GPIO 19 (pad 35) to GPIO 26 (pad 37)",
    ]


def test_too_few_free_pins_are_an_error(raises: Raises) -> None:
    with raises(UsageError, "no-free-pins"):
        choose_wires((), dict.fromkeys(range(4, 26), "motor"))


@pytest.mark.parametrize(
    "wires, kind",
    [
        ([(20, 20), (19, 26)], "wire-same-pin"),
        ([(20, 21), (21, 26)], "wire-same-pin"),
        ([(20, 40), (19, 26)], "wire-unknown-pin"),
        ([(2, 21), (19, 26)], "wire-reserved-pin"),
        ([(20, 21), (17, 26)], "wire-robot-pin"),
        ([(20, 21)], "wire-count"),
    ],
)
def test_pins_that_cannot_be_used_are_an_error(wires: list[tuple[int, int]], kind: str, raises: Raises) -> None:
    with raises(UsageError, kind):
        choose_wires(wires, {17: "left_motor"})


def test_connected_wires_have_no_problem_and_end_with_pull_downs(wired_pins: Any, fake_lgpio: Lines) -> None:
    assert [find_problem(wire, wired_pins) for wire in WIRES] == ["", ""]


def test_a_missing_wire_is_found(wired_pins: Any, check_text: CheckText) -> None:
    check_text(find_problem(LoopbackWire(1, 5, 6), wired_pins))


def test_a_wire_whose_other_end_is_on_another_pin_is_found_there(wired_pins: Any, check_text: CheckText) -> None:
    check_text(find_problem(LoopbackWire(1, 20, 26), wired_pins, others=[13, 21]))


@pytest.mark.parametrize("level", [0, 1])
def test_a_wire_on_a_supply_pad_is_found_without_driving_it(
    wired_pins: Any, fake_lgpio: Lines, monkeypatch: pytest.MonkeyPatch, level: int, check_text: CheckText
) -> None:
    fake_lgpio.fix_level(21, level)
    check_text(find_problem(WIRES[0], wired_pins))
    assert fake_lgpio.level(20) == 0
