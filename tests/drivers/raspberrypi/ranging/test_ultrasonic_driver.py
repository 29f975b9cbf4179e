import math
import threading
from typing import Any

import pytest
from gpiozero import InputDevice
from gpiozero.pins.mock import MockFactory, MockPin, MockTriggerPin

from drivers.raspberrypi.ranging.ultrasonic_driver import Ultrasonic, UltrasonicSettings, speed_of_sound
from robotcore.description import load_robot
from robotcore.errors import DescriptionError, DeviceClosedError, DeviceError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import Host, bind_devices
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


def test_open_waits_for_the_first_sample_without_simulated_time() -> None:
    bench = Bench([build_echo(1.0)])
    sample = bench.open().read()
    assert sample.distance == pytest.approx(1.0)
    assert (sample.time, sample.sequence, bench.clock.now()) == (0.0, 0, 0.0)


def test_a_distance_is_available_when_the_echo_ends_with_the_time_of_the_trigger() -> None:
    bench = Bench([build_echo(1.0), build_echo(0.4)])
    sensor = bench.open()
    bench.clock.sleep_until(0.06 + 0.004)
    assert sensor.read().distance == pytest.approx(0.4)
    assert sensor.read().time == 0.06


def test_the_ticks_of_edges_count_also_if_edges_are_reported_late() -> None:
    bench = Bench([build_echo(1.0), NO_PULSE, NO_PULSE])
    sensor = bench.open()
    bench.clock.sleep_until(0.06)
    trigger_s = bench.pins.ticks()
    bench.clock.sleep_until(0.11)
    bench.module.echo.drive(trigger_s + 0.001, True)
    bench.module.echo.drive(trigger_s + 0.001 + 1.0 / speed_of_sound(20.0), False)
    assert sensor.read().distance == pytest.approx(0.5)


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


def test_an_echo_that_is_high_from_the_start_makes_opening_raise(raises: Raises) -> None:
    bench = Bench([build_echo(1.0)])

    class Shorted(type(bench.module.echo)):  # type: ignore[misc]  # gpiozero has no types
        def _get_state(self) -> bool:
            return True

    bench.module.echo.__class__ = Shorted
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
        bench.module.echo.report_edge(trigger_s + after, level)
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


def test_edges_after_closing_are_ignored() -> None:
    bench = Bench([build_echo(1.0), NO_PULSE])
    sensor = bench.open()
    bench.clock.sleep_until(0.06)
    edge = bench.module.echo.when_changed
    sensor.close()
    assert bench.module.echo.when_changed is None
    edge(bench.pins.ticks() + 0.001, True)
    edge(bench.pins.ticks() + 0.002, False)
    bench.module.echo.drive(bench.pins.ticks() + 0.003, True)
    assert sensor._newest().sequence == 0


def test_on_the_robots_own_clock_a_thread_triggers_it_until_it_is_closed() -> None:
    pins = MockFactory(pin_class=MockPin)
    pins.pin(TRIGGER, pin_class=MockTriggerPin, echo_pin=pins.pin(ECHO), echo_time=0.002)
    clock = MonotonicClock()
    settings = UltrasonicSettings(trigger=TRIGGER, echo=ECHO, cycle_s=0.05)
    sensor = Ultrasonic().open(NOSE, settings, Host(load_robot("rover"), clock, pins))
    times = [sensor.read().time]
    while len(times) < 4:
        if (time := sensor.read().time) != times[-1]:
            times.append(time)
    assert times[0] >= 0
    assert times == sorted(times)
    assert times[-1] <= clock.now()
    sensor.close()
    assert "nose" not in [thread.name for thread in threading.enumerate()]
    clock.close()


def test_while_the_pins_fail_read_raises(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    bench = Bench([build_echo(1.0), build_echo(0.7)])
    sensor = bench.open()

    def broken(_value: Any) -> None:
        raise OSError("bad handle")

    with monkeypatch.context() as patch:
        patch.setattr(bench.module.trigger, "_set_state", broken)
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


def test_a_described_range_beyond_the_module_s_is_refused(raises: Raises) -> None:
    far = NOSE.model_copy(update={"max_range_m": 5.0})
    wires = {"raspberrypi": {"nose": {"driver": "hc-sr04", "trigger": TRIGGER, "echo": ECHO}}}
    robot = load_robot("rover").model_copy(update={"devices": (far,), "backends": wires})
    with raises(DescriptionError):
        bind_devices(robot, "raspberrypi")


def test_several_modules_make_a_row_longer(raises: Raises) -> None:
    wire = {"driver": "hc-sr04", "echo_free_cycles": 9}
    wires = {"nose": {**wire, "trigger": 16, "echo": 26}, "tail": {**wire, "trigger": 5, "echo": 6}}
    tail = NOSE.model_copy(update={"name": "tail"})
    robot = load_robot("rover").model_copy(update={"devices": (NOSE, tail), "backends": {"raspberrypi": wires}})
    with raises(DescriptionError):
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


def test_the_longest_cycle_is_used_for_all_modules(pair: Pair) -> None:
    pair.open()
    pair.settings["cycle_s"] = 0.1
    pair.open("tail", pair.tail)
    pair.clock.sleep_until(0.45)
    assert sorted(pair.module.triggers[1:] + pair.tail.triggers[1:]) == pytest.approx([0.1, 0.2, 0.3, 0.4])


def test_no_module_is_triggered_while_another_is_being_opened(pair: Pair) -> None:
    pair.open()

    def note_trigger() -> None:
        pair.clock.sleep_until(pair.clock.now() + 0.5)  # as on a robot, where opening takes time
        pair.tail._on_trigger()

    pair.tail.trigger.on_fall = note_trigger
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
