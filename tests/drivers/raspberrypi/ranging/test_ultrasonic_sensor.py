"""Several ultrasonic modules are triggered in turn."""

from __future__ import annotations

import pytest

from drivers.raspberrypi.ranging.ultrasonic_driver import Ultrasonic, UltrasonicSettings
from robotcore.description import load_robot
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import RangeSensor
from robotcore.hardware import Host
from tests.drivers.raspberrypi.ranging.modules import NOSE, Edges, Module, TimedFactory, build_echo

NOSE_GPIOS, TAIL_GPIOS = (16, 26), (5, 6)


class Pair:
    """Two ultrasonic modules on one robot, at its nose and at its tail."""

    def __init__(self, nose: list[Edges], tail: list[Edges]) -> None:
        self.clock = SteppedClock(10000, lambda _steps: None)
        self.pins = TimedFactory(self.clock)
        self.host = Host(load_robot("rover"), self.clock, self.pins)
        self.nose = Module(self.clock, self.pins, nose, gpios=NOSE_GPIOS)
        self.tail = Module(self.clock, self.pins, tail, gpios=TAIL_GPIOS)

    def open(self, name: str, module: Module, cycle_s: float = 0.06) -> RangeSensor:
        trigger, echo = module.gpios
        settings = UltrasonicSettings(trigger=trigger, echo=echo, cycle_s=cycle_s)
        module.is_immediate = True
        sensor = Ultrasonic().open(NOSE.model_copy(update={"name": name}), settings, self.host)
        module.is_immediate = False
        return sensor


@pytest.fixture
def pair() -> Pair:
    return Pair([build_echo(1.0), build_echo(0.5)], [build_echo(1.5), build_echo(0.7)])


def test_modules_are_triggered_in_turn_a_cycle_apart(pair: Pair) -> None:
    pair.open("nose", pair.nose)
    pair.open("tail", pair.tail)
    pair.clock.sleep_until(0.61)
    times = sorted((time, name) for name in ("nose", "tail") for time in getattr(pair, name).triggers[1:])
    assert [time for time, _ in times] == pytest.approx([0.06 * n for n in range(1, 11)])
    assert {name for _, name in times[::2]} != {name for _, name in times[1::2]}
    assert len({name for _, name in times[::2]}) == 1


def test_each_module_measures_its_own_echo(pair: Pair) -> None:
    nose, tail = pair.open("nose", pair.nose), pair.open("tail", pair.tail)
    pair.clock.sleep_until(0.13)
    assert (nose.read().distance, tail.read().distance) == pytest.approx((0.5, 0.7))


def test_the_longest_cycle_is_used_for_all_modules(pair: Pair) -> None:
    pair.open("nose", pair.nose, cycle_s=0.06)
    pair.open("tail", pair.tail, cycle_s=0.1)
    pair.clock.sleep_until(0.45)
    assert sorted(pair.nose.triggers[1:] + pair.tail.triggers[1:]) == pytest.approx([0.1, 0.2, 0.3, 0.4])


def test_no_module_is_triggered_while_another_is_being_opened(pair: Pair) -> None:
    pair.open("nose", pair.nose)

    def note_trigger() -> None:
        pair.clock.sleep_until(pair.clock.now() + 0.5)  # as on a robot, where opening takes time
        pair.tail._on_trigger()

    pair.tail.trigger.on_fall = note_trigger
    triggers = len(pair.nose.triggers)
    pair.open("tail", pair.tail)
    assert len(pair.nose.triggers) == triggers


def test_the_last_open_module_is_triggered_in_every_cycle(pair: Pair) -> None:
    nose, tail = pair.open("nose", pair.nose), pair.open("tail", pair.tail)
    pair.clock.sleep_until(0.13)
    nose.close()
    triggers = len(pair.nose.triggers)
    pair.clock.sleep_until(0.38)
    assert len(pair.nose.triggers) == triggers
    assert pair.tail.triggers[-4:] == pytest.approx([0.19, 0.25, 0.31, 0.37])
    tail.close()
    pair.clock.sleep_until(0.6)
    assert pair.tail.triggers[-1] == pytest.approx(0.37)
