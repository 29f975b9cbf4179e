"""An MPU-6050 on a double of an I2C bus, read by the real library."""

from __future__ import annotations

import math
import struct
import sys
from pathlib import Path
from typing import Any

import pytest

import robotcore
from drivers.raspberrypi.mpu6050 import MPU6050
from drivers.raspberrypi.polled_imu import Axis
from robotcore import Outcome, RunRequest
from robotcore.errors import DeviceClosedError, DeviceError
from robotcore.kinds import Imu
from robotcore.kinds.imu import ImuDescription
from tests.drivers.raspberrypi.i2c_bus import ChipBench, FakeChip
from tests.robotcore.description.files import ROVER
from tests.robotcore.kinds.test_imu import Circle
from tests.texts import CheckText, Raises

pytest.importorskip("adafruit_extended_bus", reason="needs pip install 'robotcore[imu]'")
pytest.importorskip("adafruit_mpu6050", reason="needs pip install 'robotcore[imu]'")

IMU = ImuDescription(kind="imu", name="imu")
G = 9.80665
POWER, WHO_AM_I, ACCELERATION, GYRO = 0x6B, 0x75, 0x3B, 0x43


class FakeMPU6050(FakeChip):
    """The registers of an MPU-6050, which sleeps after it got power. The values are those of the chip's axes."""

    width = 1
    address = 0x68

    def __init__(self) -> None:
        self.acceleration, self.rates = (0.0, 0.0, G), (0.0, 0.0, 0.0)
        self.reads_until_reset = 0
        self.identity = 0x68
        super().__init__()

    def lose_power(self) -> None:
        super().lose_power()
        self.registers[POWER] = 0x40

    def get(self, register: int) -> int:
        if register == POWER and self.reads_until_reset:
            self.reads_until_reset -= 1
            return 0x80
        if register == WHO_AM_I:
            return self.identity
        if ACCELERATION <= register < GYRO + 6:
            return 0 if self.registers[POWER] & 0x40 else self._measurement()[register - ACCELERATION]
        return self.registers[register]

    def set(self, register: int, value: int) -> None:
        if register == POWER and value & 0x80:
            self.lose_power()
        else:
            self.registers[register] = value

    def _measurement(self) -> bytes:
        forces = (round(value / G * 16384) for value in self.acceleration)
        rates = (round(math.degrees(value) * 65.5) for value in self.rates)
        return struct.pack(">7h", *forces, 0, *rates)


class Bench(ChipBench):
    """A chip on a bus."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.chip = FakeMPU6050()
        super().__init__(self.chip, patch)
        patch.setattr("adafruit_mpu6050.sleep", lambda _seconds: None)

    def open(self, **settings: Any) -> Imu:
        return MPU6050(**{"bias_s": 0.03, **settings}).open(IMU, self.context)

    def turn(self, rate: float, seconds: float) -> None:
        self.chip.rates = (0.0, 0.0, rate)
        self.clock.sleep_until(self.clock.now() + seconds)


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Bench:
    return Bench(monkeypatch)


def test_sample_has_the_turn_rate_and_the_accelerations(bench: Bench) -> None:
    imu = bench.open()
    first = imu.read()
    assert (first.time, first.sequence) == (0.0, 0)
    bench.chip.acceleration = (0.5, -0.25, G)
    bench.turn(0.8, 0.02)
    sample = imu.read()
    assert (sample.yaw_rate, sample.forward_acceleration, sample.left_acceleration) == pytest.approx(
        (0.8, 0.5, -0.25), abs=1e-3
    )
    assert (sample.time, sample.sequence) == (0.02, 2)


def test_heading_is_the_integral_of_the_turn_rate_at_each_read_of_the_chip(bench: Bench) -> None:
    imu = bench.open()
    bench.turn(1.0, 2.0)
    bench.turn(-1.0, 0.5)
    assert imu.read().heading == pytest.approx(1.5, abs=0.02)
    bench.turn(1.0, 2.5)
    assert imu.read().heading == pytest.approx(4.0 - math.tau, abs=0.02)


def test_offsets_are_measured_while_the_robot_stands_at_the_opening(bench: Bench) -> None:
    bench.chip.acceleration, bench.chip.rates = (0.3, -0.1, 9.79), (0.0, 0.0, -0.04)
    imu = bench.open()
    bench.turn(-0.04, 5.0)
    sample = imu.read()
    values = sample.yaw_rate, sample.forward_acceleration, sample.left_acceleration, sample.heading
    assert values == pytest.approx((0.0, 0.0, 0.0, 0.0), abs=1e-9)


def test_offsets_are_left_in_the_samples_without_time_to_measure_them(bench: Bench) -> None:
    bench.chip.rates = (0.0, 0.0, -0.04)
    assert bench.open(bias_s=0).read().yaw_rate == pytest.approx(-0.04, abs=1e-3)


@pytest.mark.parametrize(
    "rate, jerk, angular_acceleration",
    [(0.5, 0.0, 0.0), (-0.5, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.01)],
    ids=["turning left", "turning right", "shaken", "turning faster"],
)
def test_robot_that_moves_at_the_opening_is_refused(
    bench: Bench, raises: Raises, rate: float, jerk: float, angular_acceleration: float
) -> None:
    moments = iter(range(100))
    measure = bench.chip._measurement

    def move() -> bytes:
        moment = next(moments)
        bench.chip.rates = (0.0, 0.0, rate + angular_acceleration * moment)
        bench.chip.acceleration = (jerk * moment, 0.0, G)
        return measure()

    bench.chip._measurement = move  # type: ignore[method-assign]
    with raises(DeviceError, "not-at-rest"):
        bench.open()
    assert not bench.bus.is_open


@pytest.mark.parametrize(
    "axis, is_upside_down, forward, left, rate",
    [
        ("x", False, 1.0, 2.0, 0.5),
        ("y", False, 2.0, -1.0, 0.5),
        ("-x", False, -1.0, -2.0, 0.5),
        ("-y", False, -2.0, 1.0, 0.5),
        ("x", True, 1.0, -2.0, -0.5),
        ("y", True, 2.0, 1.0, -0.5),
    ],
)
def test_chip_can_be_mounted_in_each_direction(
    axis: Axis, is_upside_down: bool, forward: float, left: float, rate: float
) -> None:
    driver = MPU6050(forward_axis=axis, is_upside_down=is_upside_down)
    assert driver.to_robot_frame((0.1, 0.2, 0.5), (1.0, 2.0, 9.8)) == (rate, forward, left)


def test_unplugged_chip_fails_until_it_is_plugged_in_again_and_keeps_its_heading(bench: Bench, raises: Raises) -> None:
    imu = bench.open()
    bench.turn(1.0, 0.5)
    before = imu.read()
    bench.chip.is_plugged_in = False
    bench.turn(1.0, 1.0)
    with raises(DeviceError, "chip-unanswered"):
        imu.read()
    bench.chip.is_plugged_in = True
    bench.chip.lose_power()
    bench.turn(0.0, 0.01)
    after = imu.read()
    assert (after.heading, after.sequence) == (before.heading, before.sequence + 1)


def test_chip_that_lost_power_for_a_moment_is_set_up_again(bench: Bench, raises: Raises) -> None:
    imu = bench.open()
    bench.chip.lose_power()
    bench.turn(0.0, 0.01)
    with raises(DeviceError, "chip-reset"):
        imu.read()
    bench.turn(0.3, 0.01)
    assert imu.read().yaw_rate == pytest.approx(0.3, abs=1e-3)


def test_chip_that_never_ends_its_reset_does_not_hang_the_opening(bench: Bench, raises: Raises) -> None:
    bench.chip.reads_until_reset = 10**6
    with raises(DeviceError, "chip-unanswered"):
        bench.open()
    assert not bench.bus.is_open


def test_another_chip_at_its_address_is_refused(bench: Bench, raises: Raises) -> None:
    bench.chip.identity = 0x70
    with raises(DeviceError, "wrong-chip"):
        bench.open()
    assert not bench.bus.is_open


def test_closing_closes_the_bus(bench: Bench) -> None:
    imu = bench.open()
    imu.close()
    bench.turn(0.0, 0.1)
    assert not bench.bus.is_open
    with pytest.raises(DeviceClosedError):
        imu.read()


def test_missing_library_is_reported_with_its_remedy(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setitem(sys.modules, "adafruit_mpu6050", None)
    with raises(DeviceError, "library-missing"):
        bench.open()


def test_notes_say_how_to_mount_the_chip_and_that_the_robot_must_stand(check_text: CheckText) -> None:
    check_text("\n".join([*MPU6050(forward_axis="-y").notes(IMU), *MPU6050(bias_s=0).notes(IMU)]))
    assert str(MPU6050(address=0x69).connections()[2]) == "I2C 0x69 on bus 1"


def test_on_virtual_pins_the_simulators_imu_replaces_the_chip(tmp_path: Path) -> None:
    file = tmp_path / "imu.toml"
    file.write_text(f'{ROVER}\n[[devices]]\nkind = "imu"\nname = "imu"\n\n[raspberrypi.imu]\ndriver = "mpu6050"\n')
    Circle.samples.clear()
    result = robotcore.run(RunRequest(Circle, robot=str(file), backend="virtualpi", world="open"))
    assert result.outcome is Outcome.SUCCESS
    assert Circle.samples[-1].heading == pytest.approx(1.4, abs=0.1)
