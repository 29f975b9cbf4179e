import math
import sys
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import pytest

from drivers.raspberrypi.ranging.time_of_flight_driver import VL53L0X, VL53L1X, TimeOfFlight
from robotcore.description import load_robot
from robotcore.errors import DescriptionError, DeviceClosedError, DeviceError
from robotcore.hardware import DeviceContext, bind_devices
from robotcore.kinds.range_sensor import RangeSensor
from tests.drivers.raspberrypi.i2c_bus import ChipBench
from tests.drivers.raspberrypi.ranging.lightbus import FakeLaser, FakeVL53L0X, FakeVL53L1X
from tests.drivers.raspberrypi.ranging.modules import NOSE
from tests.texts import Raises

pytest.importorskip("adafruit_extended_bus", reason="needs pip install 'robotcore[tof]'")

DESCRIPTION = NOSE.model_copy(update={"max_range_m": 1.2})


@dataclass
class ChipCase:
    """A driver, its chip, and the chip's status for a target, for a target beyond, and for no target."""

    driver: type[TimeOfFlight]
    chip: type[FakeLaser]
    target: int
    beyond: int
    nothing: int
    too_near: int
    unclear: int


KINDS = [
    ChipCase(VL53L0X, FakeVL53L0X, target=11, beyond=6, nothing=4, too_near=10, unclear=7),
    ChipCase(VL53L1X, FakeVL53L1X, target=9, beyond=5, nothing=4, too_near=8, unclear=6),
]
BROKEN = 2


class Bench(ChipBench):
    """A double of a chip on a bus, and the driver that reads it by the real library."""

    def __init__(self, kind: ChipCase, patch: pytest.MonkeyPatch) -> None:
        self.kind = kind
        self.chip = kind.chip(kind.target, 500)
        super().__init__(self.chip, patch)

    def open(self, **settings: Any) -> RangeSensor:
        return self.kind.driver(**settings).open(DESCRIPTION, self.context)

    def set_measurement(self, status: int, millimetres: int = 500, cycles: int = 1) -> None:
        self.chip.status, self.chip.millimetres = status, millimetres
        self.cycles(cycles)

    def cycles(self, count: int = 1) -> None:
        self.clock.sleep_until(self.clock.now() + 0.05 * count)


@pytest.fixture(params=KINDS, ids=lambda kind: str(kind.driver.name))
def bench(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Bench:
    return Bench(request.param, monkeypatch)


def test_each_measurement_is_a_sample_of_the_cycle_before(bench: Bench) -> None:
    sensor = bench.open()
    bench.set_measurement(bench.kind.target, 750)
    bench.set_measurement(bench.kind.target, 800)
    sample = sensor.read()
    assert (sample.distance, sample.time, sample.sequence) == pytest.approx((0.8, 0.05, 2))


def test_nearer_than_min_range_reads_min_range(bench: Bench) -> None:
    sensor = bench.open()
    bench.set_measurement(bench.kind.target, 3)
    assert sensor.read().distance == DESCRIPTION.min_range_m
    bench.set_measurement(bench.kind.target)
    bench.set_measurement(bench.kind.too_near, 700)
    assert (sensor.read().distance, sensor.read().sequence) == (DESCRIPTION.min_range_m, 3)


def test_a_target_beyond_the_range_is_inf_by_its_distance_and_by_its_status(bench: Bench) -> None:
    sensor = bench.open()
    bench.set_measurement(bench.kind.target, 1300)
    assert (sensor.read().distance, sensor.read().sequence) == (math.inf, 1)
    bench.set_measurement(bench.kind.beyond, 300)
    assert (sensor.read().distance, sensor.read().sequence) == (math.inf, 2)


def test_too_little_light_gives_no_new_sample_and_a_row_of_it_gives_inf(bench: Bench) -> None:
    sensor = bench.open(echo_free_cycles=3)
    first = sensor.read()
    bench.set_measurement(bench.kind.nothing, cycles=2)
    bench.set_measurement(bench.kind.unclear)
    bench.set_measurement(bench.kind.nothing, cycles=2)
    assert sensor.read() is first
    bench.cycles()
    assert sensor.read().distance == math.inf


@pytest.mark.slow
def test_without_a_first_result_opening_raises_and_closes_the_bus(bench: Bench, raises: Raises) -> None:
    bench.chip.status = bench.kind.unclear
    with raises(DeviceError, "no-sample-yet"):
        bench.open(cycle_s=0.02)
    assert not bench.bus.is_open


def test_a_chip_that_is_unplugged_fails_until_it_is_plugged_in_again(bench: Bench, raises: Raises) -> None:
    sensor = bench.open()
    bench.chip.is_plugged_in = False
    bench.cycles()
    with raises(DeviceError, "chip-unanswered"):
        sensor.read()
    bench.cycles(3)
    with raises(DeviceError, "chip-unanswered"):
        sensor.read()
    bench.chip.is_plugged_in = True
    bench.chip.lose_power()
    bench.set_measurement(bench.kind.target, 650)
    assert (sensor.read().distance, sensor.read().sequence) == (0.65, 1)


def test_a_chip_that_stops_measuring_fails_and_is_connected_again(bench: Bench, raises: Raises) -> None:
    sensor = bench.open()
    bench.chip.is_frozen = True
    bench.cycles(21)
    with raises(DeviceError, "chip-stalled"):
        sensor.read()
    bench.chip.is_frozen = False
    bench.cycles()
    assert sensor.read().sequence == 1


def test_a_broken_laser_is_reported(bench: Bench, raises: Raises) -> None:
    sensor = bench.open()
    bench.set_measurement(BROKEN)
    with raises(DeviceError, "laser-broken"):
        sensor.read()


def test_closing_stops_the_laser_and_closes_the_bus(bench: Bench) -> None:
    sensor = bench.open()
    assert bench.chip.is_measuring
    sensor.close()
    assert not bench.chip.is_measuring
    assert not bench.bus.is_open
    bench.cycles(3)
    assert not bench.bus.is_open
    with pytest.raises(DeviceClosedError):
        sensor.read()


def test_another_chip_at_its_address_is_refused(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    bench = Bench(KINDS[1], monkeypatch)
    bench.bus.chip = FakeVL53L0X(11, 500)
    with raises(DeviceError, "wrong-chip"):
        bench.open()


def test_a_chip_that_never_measures_does_not_hang_the_opening(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    bench.chip.is_frozen = True
    monkeypatch.setattr("adafruit_vl53l1x.time", SimpleNamespace(sleep=lambda _seconds: None))
    with pytest.raises(DeviceError) as raised:
        bench.open(cycle_s=0.02)
    assert raised.value.device == "nose"
    assert not bench.bus.is_open


def test_a_library_that_is_missing_is_reported_with_its_remedy(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setitem(sys.modules, f"adafruit_{bench.kind.driver.name}", None)
    with raises(DeviceError, "library-missing"):
        bench.open()


@pytest.mark.parametrize("max_range_m, is_short", [(1.3, True), (1.4, False)])
def test_a_vl53l1x_uses_its_long_range_mode_only_if_needed(
    max_range_m: float, is_short: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = Bench(KINDS[1], monkeypatch)
    description = DESCRIPTION.model_copy(update={"max_range_m": max_range_m})
    VL53L1X().open(description, DeviceContext(load_robot("rover"), bench.clock))
    assert bench.chip.registers[0x004B] == (0x14 if is_short else 0x0A)


def test_the_lines_are_shared_and_the_address_is_not() -> None:
    wires = VL53L0X().connections()
    assert [(wire.signal, str(wire), wire.is_shared) for wire in wires] == [
        ("SDA", "GPIO 2", True),
        ("SCL", "GPIO 3", True),
        ("address", "I2C 0x29 on bus 1", False),
    ]
    assert str(VL53L0X(bus=3).connections()[0]) == "I2C SDA of bus 3"


@pytest.mark.parametrize("wrong", [{"driver": "vl53l0x"}, {"driver": "vl53l1x", "cycle_s": 0.1}])
def test_a_range_beyond_the_chips_and_a_row_of_cycles_beyond_the_age_limit_are_refused(
    wrong: dict[str, Any], raises: Raises
) -> None:
    robot = load_robot("rover").model_copy(update={"devices": (NOSE,), "backends": {"raspberrypi": {"nose": wrong}}})
    with raises(DescriptionError, "setting-conflict"):
        bind_devices(robot, "raspberrypi")
