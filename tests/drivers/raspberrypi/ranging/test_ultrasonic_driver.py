import math
from unittest.mock import Mock

import pytest
from gpiozero import InputDevice

from robotcore.description import load_robot
from robotcore.errors import DescriptionError, DeviceClosedError, DeviceError
from robotcore.hardware import bind_devices
from tests.drivers.raspberrypi.ranging.modules import (
    ECHO,
    NO_ECHO,
    NO_PULSE,
    NOSE,
    TRIGGER,
    Bench,
    Edges,
    Module,
    build_echo,
    pulse,
)
from tests.texts import Raises

LOST_RISE: Edges = ((0.003, False),)
LOST_FALL: Edges = ((0.0005, True),)


def test_a_distance_is_available_when_the_echo_ends_with_the_time_of_the_trigger() -> None:
    bench = Bench([build_echo(1.0), build_echo(0.4)])
    sensor = bench.open()
    bench.clock.sleep_until(0.06 + 0.004)
    assert sensor.read().distance == pytest.approx(0.4)
    assert sensor.read().time == 0.06


def test_each_row_of_echo_free_cycles_gives_inf() -> None:
    bench = Bench([build_echo(1.0), NO_ECHO], {"echo_free_cycles": 4})
    sensor = bench.open()
    bench.cycles(3)
    assert sensor.read().distance == pytest.approx(1.0)
    bench.cycles()
    assert (sensor.read().distance, sensor.read().time) == pytest.approx((math.inf, 0.24))
    bench.cycles()
    assert (sensor.read().distance, sensor.read().time) == pytest.approx((math.inf, 0.30))


def test_with_nothing_in_range_it_opens_with_inf_without_simulated_time() -> None:
    bench = Bench([NO_ECHO])
    assert bench.open().read().distance == math.inf
    assert (bench.clock.now(), len(bench.module.triggers)) == (0.0, 10)


def test_without_a_first_result_opening_raises(raises: Raises) -> None:
    with raises(DeviceError, "no-sample-yet"):
        Bench([NO_ECHO], {"echo_free_cycles": 0}).open()


def test_a_module_that_times_out_late_is_not_triggered_before_its_echo_ends() -> None:
    bench = Bench([build_echo(1.0), pulse(0.2)], {"echo_free_cycles": 2})
    sensor = bench.open()
    bench.cycles(5)
    assert bench.module.triggers == pytest.approx([0.0, 0.06, 0.30])
    bench.cycles(3)
    assert (sensor.read().distance, sensor.read().time) == pytest.approx((math.inf, 0.30))


@pytest.mark.slow
def test_without_an_answer_opening_raises_and_frees_the_pins(raises: Raises) -> None:
    bench = Bench([NO_PULSE])
    with raises(DeviceError, "trigger-unanswered"):
        bench.open()
    bench.module.pulses = [build_echo(1.0)]
    assert bench.open().read().distance == pytest.approx(1.0)


def test_after_five_triggers_without_an_answer_read_raises_until_the_module_answers(raises: Raises) -> None:
    bench = Bench([build_echo(1.0), *[NO_PULSE] * 7, build_echo(0.8)])
    sensor = bench.open()
    bench.cycles(5)
    assert sensor.read().sequence == 0
    bench.cycles()
    with raises(DeviceError, "trigger-unanswered"):
        sensor.read()
    bench.cycles(2)
    assert (sensor.read().distance, sensor.read().sequence) == pytest.approx((0.8, 1))


def test_while_the_echo_stays_high_read_raises_and_there_is_no_trigger(raises: Raises) -> None:
    bench = Bench([build_echo(1.0), pulse(0.5), build_echo(0.8)])
    sensor = bench.open()
    bench.cycles(7)
    assert len(bench.module.triggers) == 2
    with raises(DeviceError, "echo-stuck"):
        sensor.read()
    bench.cycles(2)
    assert not bench.module.echo.state
    with raises(DeviceError, "echo-stuck"):
        sensor.read()
    bench.cycles()
    assert (sensor.read().distance, sensor.read().sequence) == pytest.approx((0.8, 1))


@pytest.mark.slow
def test_an_echo_that_is_high_from_the_start_makes_opening_raise(raises: Raises) -> None:
    bench = Bench([build_echo(1.0)])
    bench.module.echo._get_state = lambda: True
    with raises(DeviceError, "echo-stuck"):
        bench.open()
    assert not bench.module.triggers


@pytest.mark.parametrize(
    "edges",
    [
        LOST_RISE,
        ((0.0005, True), (0.003, True), (0.004, False)),
        ((0.0005, False), (0.003, True), (0.004, False)),
    ],
)
def test_a_cycle_that_lost_an_edge_gives_no_value(edges: Edges) -> None:
    bench = Bench([build_echo(1.0), NO_PULSE, build_echo(0.8)])
    sensor = bench.open()
    bench.clock.sleep_until(0.06)
    trigger_s = bench.pins.ticks()
    bench.clock.sleep_until(0.08)
    for after, level in edges:
        bench.module.echo.when_changed(trigger_s + after, level)
    assert sensor.read().sequence == 0
    bench.cycles()
    assert sensor.read().distance == pytest.approx(0.8)


def test_the_airs_temperature_sets_the_speed_of_sound() -> None:
    bench = Bench([build_echo(1.0, 35.0)], {"air_temperature_c": 35.0})
    assert bench.open().read().distance == pytest.approx(1.0)


def test_closing_stops_the_triggers_and_frees_the_pins() -> None:
    bench = Bench([build_echo(1.0)])
    sensor = bench.open()
    sensor.close()
    bench.cycles(5)
    assert len(bench.module.triggers) == 1
    assert sensor._newest().sequence == 0
    with pytest.raises(DeviceClosedError):
        sensor.read()
    assert bench.open().read().distance == pytest.approx(1.0)


def test_while_the_pins_fail_read_raises(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    bench = Bench([build_echo(1.0), build_echo(0.7)])
    sensor = bench.open()
    with monkeypatch.context() as patch:
        patch.setattr(bench.module.trigger, "_set_state", Mock(side_effect=OSError("bad handle")))
        bench.cycles()
        with raises(DeviceError, "driver-failed"):
            sensor.read()
    bench.cycles()
    assert sensor.read().distance == pytest.approx(0.7)


@pytest.mark.parametrize("taken", [TRIGGER, ECHO])
def test_the_pin_in_use_is_reported_and_the_other_is_freed(taken: int, raises: Raises) -> None:
    bench = Bench([build_echo(1.0)])
    with (
        InputDevice(taken, pin_factory=bench.pins),
        raises(DeviceError, "gpio-in-use"),
    ):
        bench.open()
    assert bench.open().read().distance == pytest.approx(1.0)


def test_a_described_range_beyond_the_modules_is_refused(raises: Raises) -> None:
    far = NOSE.model_copy(update={"max_range_m": 5.0})
    wires = {"raspberrypi": {"nose": {"driver": "hc-sr04", "trigger": TRIGGER, "echo": ECHO}}}
    robot = load_robot("rover").model_copy(update={"devices": (far,), "backends": wires})
    with raises(DescriptionError, "setting-conflict"):
        bind_devices(robot, "raspberrypi")


def test_several_modules_make_a_row_longer(raises: Raises) -> None:
    wire = {"driver": "hc-sr04", "echo_free_cycles": 9}
    wires = {"nose": {**wire, "trigger": 16, "echo": 26}, "tail": {**wire, "trigger": 5, "echo": 6}}
    tail = NOSE.model_copy(update={"name": "tail"})
    robot = load_robot("rover").model_copy(update={"devices": (NOSE, tail), "backends": {"raspberrypi": wires}})
    with raises(DescriptionError, "setting-conflict"):
        bind_devices(robot, "raspberrypi")
    for each in wires.values():
        each["echo_free_cycles"] = 8
    assert bind_devices(robot, "raspberrypi")


class Pair(Bench):
    """Two modules on one robot, at its nose and at its tail."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self.tail = Module(self.clock, self.pins, [build_echo(1.5), build_echo(0.7)], gpios=(5, 6))


@pytest.fixture
def pair() -> Pair:
    return Pair([build_echo(1.0), build_echo(0.5)])


def test_modules_are_triggered_in_turn_a_cycle_apart(pair: Pair) -> None:
    pair.open()
    pair.open("tail", pair.tail)
    pair.clock.sleep_until(0.61)
    nose, tail = (set(module.triggers[1:]) for module in (pair.module, pair.tail))
    times = sorted(nose | tail)
    assert times == pytest.approx([0.06 * n for n in range(1, 11)])
    assert {*times[::2]} in (nose, tail)


def test_no_module_is_triggered_while_another_is_being_opened(pair: Pair) -> None:
    pair.open()
    # as on a robot, where opening takes time
    pair.tail.trigger.on_change(lambda: pair.clock.sleep_until(pair.clock.now() + 0.5))
    triggers = len(pair.module.triggers)
    pair.open("tail", pair.tail)
    assert len(pair.module.triggers) == triggers


def test_the_last_open_module_is_triggered_in_every_cycle(pair: Pair) -> None:
    nose, tail = pair.open(), pair.open("tail", pair.tail)
    pair.clock.sleep_until(0.13)
    nose.close()
    triggers = len(pair.module.triggers)
    pair.clock.sleep_until(0.38)
    assert len(pair.module.triggers) == triggers
    assert pair.tail.triggers[-4:] == pytest.approx([0.19, 0.25, 0.31, 0.37])
    tail.close()
    pair.clock.sleep_until(0.6)
    assert pair.tail.triggers[-1] == pytest.approx(0.37)
