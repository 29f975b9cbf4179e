"""Faults in a field of the samples of a battery, a bumper, and a sensor of another package with several fields."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
import pytest

from robotcore import plugins
from robotcore.description import DeviceDescription, Mount
from robotcore.errors import UsageError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.kind import Kind, build_sensor
from robotcore.kinds.battery import BatteryDescription, Voltage
from robotcore.kinds.bumper import BumperDescription, Touch
from robotcore.kinds.gamepad import AXES, BUTTONS, TRIGGERS, GamepadDescription, GamepadSample
from robotcore.kinds.imu import ImuDescription, ImuSample
from robotcore.kinds.lidar import LidarDescription, Scan
from robotcore.kinds.line_sensor import Darkness, LineSensorDescription
from robotcore.runtime.faults import plan_faults
from tests.robotcore.runtime.faults.conftest import Register
from tests.robotcore.runtime.faults.rigs import TICK_S, build_rover
from tests.texts import Raises


class WeatherDescription(DeviceDescription):
    """A weather station."""

    kind: Literal["weather"]


@dataclass(frozen=True)
class Weather:
    """A sample of a weather station."""

    heat: Annotated[float, Unit("°C")]
    drops: Annotated[int, Unit("")]
    is_day: Annotated[bool, Unit("")]
    note: str
    time: float
    sequence: int


class WeatherStation(Sensor[Weather]):
    """A weather station."""

    kind = "weather"


KIND = Kind("a weather station", WeatherDescription, WeatherStation, Weather)
BATTERY = BatteryDescription(kind="battery", name="cells")
BUMPER = BumperDescription(kind="bumper", name="front")
STATION = WeatherDescription(kind="weather", name="roof")


@pytest.fixture(autouse=True)
def _registered(register: Register) -> None:
    register("weather", f"{__name__}:KIND", plugins.KINDS)


def read(
    spec: str, device: DeviceDescription, take: Callable[[float, int], Any], ticks: int, seed: int = 1
) -> list[Any]:
    """Return the samples of a sensor with a fault, one a tick. ``take`` takes a sample."""
    clock = SteppedClock(20, lambda _: None)
    samples: list[Any] = []
    sensor = build_sensor(device, lambda: take(clock.now(), len(samples)))
    (planned,) = plan_faults([spec], build_rover(device), [device.name])
    changed = planned.layer(clock, seed).sensor(sensor, sensor.read)
    for _ in range(ticks):
        samples.append(changed())
        clock.sleep_until(clock.now() + TICK_S)
    return samples


def read_voltages(spec: str, ticks: int, seed: int = 1) -> list[float]:
    samples = read(spec, BATTERY, lambda time, sequence: Voltage(12.0, time, sequence), ticks, seed)
    assert [sample.sequence for sample in samples] == list(range(ticks))
    assert {type(sample.voltage) for sample in samples} == {float}
    return [sample.voltage for sample in samples]


def read_contacts(spec: str, ticks: int, *, is_pressed: bool = False) -> list[bool]:
    samples = read(spec, BUMPER, lambda time, sequence: Touch(is_pressed, time, sequence), ticks)
    assert {type(sample.is_pressed) for sample in samples} == {bool}
    return [sample.is_pressed for sample in samples]


def read_weather(spec: str, ticks: int = 1) -> list[Weather]:
    return read(spec, STATION, lambda time, sequence: Weather(21.5, 7, True, "dry", time, sequence), ticks)


class TestNoise:
    def test_noise_has_the_given_deviation_and_no_bias(self) -> None:
        voltages = read_voltages("battery noise=0.5", 500)
        assert np.std(voltages) == pytest.approx(0.5, rel=0.1)
        assert np.mean(voltages) == pytest.approx(12.0, abs=0.1)

    def test_seed_determines_the_noise(self) -> None:
        first, again, other = (read_voltages("battery noise=0.5", 5, seed) for seed in (1, 1, 2))
        assert first == again
        assert set(first).isdisjoint(other)


def test_bias_is_added_during_the_fault() -> None:
    assert read_voltages("cells bias=-2 after=0.05 lasts=0.1", 4) == [12.0, 10.0, 10.0, 12.0]


class TestStuck:
    def test_number_has_the_stuck_value_during_the_fault(self) -> None:
        assert read_voltages("battery stuck=6 after=0.05 lasts=0.1", 4) == [12.0, 6.0, 6.0, 12.0]

    @pytest.mark.parametrize("value", [0, 1])
    def test_contact_is_pressed_or_not_during_the_fault(self, value: int) -> None:
        contacts = read_contacts(f"bumper stuck={value} after=0.05 lasts=0.05", 3, is_pressed=not value)
        assert contacts == [not value, bool(value), not value]


class TestSpikes:
    def test_spikes_of_a_number_have_their_size_and_the_given_share(self) -> None:
        voltages = read_voltages("battery spikes=0.3 size=2", 1000)
        assert set(voltages) == {10.0, 12.0, 14.0}
        assert voltages.count(10.0) == pytest.approx(150, abs=40)
        assert voltages.count(14.0) == pytest.approx(150, abs=40)

    @pytest.mark.parametrize("is_pressed", [False, True])
    def test_spikes_reverse_a_contact_with_the_given_share(self, *, is_pressed: bool) -> None:
        contacts = read_contacts("bumper spikes=0.3", 1000, is_pressed=is_pressed)
        assert contacts.count(not is_pressed) == pytest.approx(300, abs=45)


class TestSeveralFields:
    @pytest.mark.parametrize(
        "spec, changed",
        [
            ("weather bias=1.5 field=heat", Weather(23.0, 7, True, "dry", 0.0, 0)),
            ("weather bias=1.6 field=drops", Weather(21.5, 9, True, "dry", 0.0, 0)),
            ("roof stuck=0 field=is_day", Weather(21.5, 7, False, "dry", 0.0, 0)),
            ("weather spikes=1 field=is_day", Weather(21.5, 7, False, "dry", 0.0, 0)),
            ("weather stuck=107 field=drops lasts=0.01", Weather(21.5, 107, True, "dry", 0.0, 0)),
        ],
    )
    def test_only_the_named_field_changes_and_keeps_its_type(self, spec: str, changed: Weather) -> None:
        (sample,) = read_weather(spec)
        assert sample == changed
        assert type(sample.drops) is int

    @pytest.mark.parametrize("effect", ["drop=1", "freeze", "delay=0.1"])
    def test_timing_faults_fit_a_kind_of_another_package(self, effect: str) -> None:
        assert [sample.sequence for sample in read_weather(f"weather {effect}", 3)] == [0, 0, 0]


@pytest.mark.parametrize(
    "spec",
    [
        "weather noise=1",
        "weather noise=1 field=heatt",
        "weather noise=1 field=is_day",
        "weather stuck=1 field=note",
        "weather stuck=0.5 field=is_day",
        "weather spikes=0.1 field=heat",
        "weather spikes=0.1 field=is_day size=1",
        "weather spikes=0.1 field=is_day size=0",
    ],
)
def test_wrong_field_or_value_is_refused_with_the_fields(spec: str, raises: Raises) -> None:
    with raises(UsageError, "fault-parameter"):
        plan_faults([spec], build_rover(STATION), ["roof"])


LIDAR = LidarDescription(kind="lidar", name="scan", mount=Mount(z_m=0.1), min_range_m=0.1, max_range_m=2.0, count=3)
ROW = LineSensorDescription(kind="line_sensor", name="row", mount=Mount(z_m=0.01), count=3, spacing_m=0.01)
IMU = ImuDescription(kind="imu", name="imu")
PAD = GamepadDescription(kind="gamepad", name="pad")
AT_REST: Any = dict.fromkeys((*AXES, *TRIGGERS), 0.0) | dict.fromkeys(BUTTONS, False)


@pytest.mark.parametrize(
    "spec, device, sample, limited",
    [
        ("cells bias=-9", BATTERY, Voltage(7.0, 0.0, 0), {"voltage": 0.0}),
        ("scan bias=1", LIDAR, Scan((0.5, 1.5, math.inf), 0.0, 0), {"distances": (1.5, math.inf, math.inf)}),
        ("scan bias=-0.5", LIDAR, Scan((0.5, 1.5, math.inf), 0.0, 0), {"distances": (math.inf, 1.0, math.inf)}),
        ("row bias=0.6", ROW, Darkness((0.0, 0.5, 1.0), 0.0, 0), {"values": (0.6, 1.0, 1.0)}),
        ("row bias=-0.6", ROW, Darkness((0.0, 0.5, 1.0), 0.0, 0), {"values": (0.0, 0.0, 0.4)}),
        ("imu bias=1 field=heading", IMU, ImuSample(0.0, 0.0, 0.0, 3.0, 0.0, 0), {"heading": 4.0 - math.tau}),
        ("pad bias=2 field=left_x", PAD, GamepadSample(**AT_REST, time=0.0, sequence=0), {"left_x": 1.0}),
        ("pad bias=-2 field=left_x", PAD, GamepadSample(**AT_REST, time=0.0, sequence=0), {"left_x": -1.0}),
        ("pad bias=-2 field=left_trigger", PAD, GamepadSample(**AT_REST, time=0.0, sequence=0), {"left_trigger": 0.0}),
    ],
)
def test_changed_values_stay_within_the_limits_of_the_hardware(
    spec: str, device: DeviceDescription, sample: Any, limited: dict[str, Any]
) -> None:
    (changed,) = read(spec, device, lambda *_: sample, 1)
    assert {field: getattr(changed, field) for field in limited} == {
        field: pytest.approx(value) for field, value in limited.items()
    }
