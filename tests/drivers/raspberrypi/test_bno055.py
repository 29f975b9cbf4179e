"""A BNO055 on a double of an I2C bus, read by the real library."""

from __future__ import annotations

import math
import struct
from collections import Counter
from types import SimpleNamespace
from typing import Any

import pytest

from drivers.raspberrypi.bno055 import BNO055
from drivers.raspberrypi.polled_imu import Axis
from robotcore.description import load_robot
from robotcore.errors import DeviceClosedError, DeviceError
from robotcore.hal.clock import SteppedClock
from robotcore.hardware import DeviceContext
from robotcore.kinds import Imu
from robotcore.kinds.imu import ImuDescription
from tests.drivers.raspberrypi.i2c_bus import ChipBench, FakeChip
from tests.texts import CheckText, Raises

extended_bus = pytest.importorskip("adafruit_extended_bus", reason="needs pip install 'robotcore[imu]'")
pytest.importorskip("adafruit_bno055", reason="needs pip install 'robotcore[imu]'")

IMU = ImuDescription(kind="imu", name="imu")
IDENTITY, PAGE, GYRO, EULER, LINEAR, STATUS, MODE, TRIGGER, MAP, SIGN = (
    0x00,
    0x07,
    0x14,
    0x1A,
    0x28,
    0x35,
    0x3D,
    0x3F,
    0x41,
    0x42,
)
IMU_MODE = 0x08


class FakeBNO055(FakeChip):
    """The registers of a BNO055. ``rates`` and ``acceleration`` are those of the axes that are printed on the board.

    ``angle`` is the direction of the chip in radians, positive to the left seen from above.
    """

    width = 1
    address = 0x28

    def __init__(self) -> None:
        self.rates, self.acceleration, self.angle = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0
        self.gyro_status = 3
        self.identity = 0xA0
        self.errors: Counter[int] = Counter()
        super().__init__()

    def lose_power(self) -> None:
        """Reset the registers. The angle counts from here."""
        super().lose_power()
        self.registers |= {IDENTITY: self.identity, MAP: 0x24}
        self.zero = self.angle

    def get(self, register: int) -> int:
        if self.registers[PAGE] == 1 or register not in range(GYRO, STATUS + 1):
            return self.registers[register]
        if register == STATUS:
            return self.gyro_status << 4
        is_wrong = self.errors[register] > 0
        self.errors[register] -= is_wrong
        return self._measure()[register - GYRO] ^ (0x80 if is_wrong else 0)

    def set(self, register: int, value: int) -> None:
        if register == TRIGGER and value == 0x20:
            self.lose_power()
        elif self.registers[PAGE] == 0 or register == PAGE:
            self.registers[register] = value

    def _measure(self) -> bytes:
        if self.registers[MODE] != IMU_MODE:
            return bytes(STATUS - GYRO)
        rates = (round(math.degrees(value) * 16) for value in self._remap(self.rates))
        forces = (round(value * 100) for value in self._remap(self.acceleration))
        heading = round(math.degrees(self.zero - self.angle) % 360 * 16)  # to the right
        return struct.pack("<3h3h8x3h7x", *rates, heading, 0, 0, *forces)

    def _remap(self, values: tuple[float, float, float]) -> list[float]:
        sources = [self.registers[MAP] >> 2 * place & 3 for place in range(3)]
        signs = [-1 if self.registers[SIGN] >> (2 - place) & 1 else 1 for place in range(3)]
        return [sign * values[source] for sign, source in zip(signs, sources, strict=True)]


class Bench(ChipBench):
    """A chip on a bus."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.chip = FakeBNO055()
        super().__init__(self.chip, patch)
        patch.setattr("adafruit_bno055.time", SimpleNamespace(sleep=lambda _seconds: None))

    def open(self, **settings: Any) -> Imu:
        return BNO055(**settings).open(IMU, self.context)

    def turn(self, rate: float, seconds: float) -> None:
        """Turn the chip to the left, at a rate in rad/s."""
        self.chip.rates = (0.0, 0.0, rate)
        for _ in range(round(seconds / 0.01)):
            self.chip.angle += rate * 0.01
            self.clock.sleep_until(self.clock.now() + 0.01)


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Bench:
    return Bench(monkeypatch)


def test_sample_has_the_turn_rate_the_accelerations_and_the_heading_to_the_left(bench: Bench) -> None:
    imu = bench.open()
    assert (imu.read().heading, imu.read().time, imu.read().sequence) == (0.0, 0.0, 0)
    bench.chip.acceleration = (0.5, -0.25, 0.1)
    bench.turn(0.5, 1.0)
    sample = imu.read()
    values = sample.yaw_rate, sample.forward_acceleration, sample.left_acceleration, sample.heading
    assert values == pytest.approx((0.5, 0.5, -0.25, 0.5), abs=0.01)
    assert (sample.time, sample.sequence) == (1.0, 50)


def test_heading_counts_from_the_opening_to_both_sides_of_pi(bench: Bench) -> None:
    bench.turn(1.0, 2.0)
    imu = bench.open()
    assert imu.read().heading == 0.0
    bench.turn(1.5, 2.0)
    assert imu.read().heading == pytest.approx(3.0, abs=0.03)
    bench.turn(1.5, 0.4)
    assert imu.read().heading == pytest.approx(3.6 - math.tau, abs=0.03)


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
    bench: Bench, axis: Axis, is_upside_down: bool, forward: float, left: float, rate: float
) -> None:
    bench.chip.acceleration, bench.chip.rates = (1.0, 2.0, 0.0), (0.1, 0.2, 0.5)
    sample = bench.open(forward_axis=axis, is_upside_down=is_upside_down).read()
    found = sample.forward_acceleration, sample.left_acceleration, sample.yaw_rate
    assert found == pytest.approx((forward, left, rate), abs=1e-3)


def test_uncalibrated_chip_is_refused(bench: Bench, raises: Raises) -> None:
    bench.chip.gyro_status = 2
    with raises(DeviceError, "not-calibrated"):
        bench.open(calibration_s=0.1)
    assert not bench.bus.is_open


def test_opening_waits_for_the_calibration(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    bench.chip.gyro_status = 0
    read, reads = bench.chip.get, iter(range(10**6))

    def get(register: int) -> int:
        if register == STATUS and next(reads) == 3:
            bench.chip.gyro_status = 3
        return read(register)

    monkeypatch.setattr(bench.chip, "get", get)
    assert bench.open(calibration_s=1).read().heading == 0.0


def test_unplugged_chip_fails_until_it_is_calibrated_again_and_keeps_its_heading(bench: Bench, raises: Raises) -> None:
    imu = bench.open()
    bench.turn(1.0, 0.5)
    before = imu.read()
    bench.chip.is_plugged_in = False
    bench.turn(1.0, 1.0)
    with raises(DeviceError, "chip-unanswered"):
        imu.read()
    bench.chip.is_plugged_in = True
    bench.chip.lose_power()
    bench.chip.gyro_status = 1
    bench.turn(0.0, 0.1)
    with raises(DeviceError, "not-calibrated"):
        imu.read()
    bench.chip.gyro_status = 3
    bench.turn(0.0, 0.02)
    after = imu.read()
    assert (after.heading, after.sequence) == (before.heading, before.sequence + 1)


def test_chip_that_lost_power_for_a_moment_is_set_up_again(bench: Bench, raises: Raises) -> None:
    imu = bench.open()
    bench.chip.lose_power()
    bench.turn(0.0, 0.02)
    with raises(DeviceError, "chip-reset"):
        imu.read()
    bench.turn(0.3, 0.02)
    assert imu.read().yaw_rate == pytest.approx(0.3, abs=1e-3)


@pytest.mark.parametrize("register", [GYRO + 5, EULER, EULER + 1, LINEAR + 1], ids=["rate", "8°", "heading", "force"])
def test_misread_value_is_read_again(bench: Bench, register: int) -> None:
    imu = bench.open()
    bench.turn(1.0, 0.5)
    bench.chip.errors[register] = 2
    bench.turn(1.0, 0.02)
    sample = imu.read()
    assert (sample.time, sample.heading) == pytest.approx((0.52, 0.52), abs=0.01)
    assert bench.chip.errors[register] == 0


def test_chip_that_is_misread_again_and_again_is_an_error_until_it_is_not(bench: Bench, raises: Raises) -> None:
    imu = bench.open()
    bench.chip.errors[EULER + 1] = 30
    bench.turn(1.0, 0.1)
    with raises(DeviceError, "chip-misread"):
        imu.read()
    bench.turn(1.0, 0.4)
    assert imu.read().heading == pytest.approx(0.5, abs=0.01)


def test_misread_chip_on_another_bus_is_an_error_about_its_wires(bench: Bench, raises: Raises) -> None:
    imu = bench.open(bus=3)
    bench.chip.errors[EULER + 1] = 30
    bench.turn(1.0, 0.1)
    with raises(DeviceError, "chip-misread"):
        imu.read()


@pytest.mark.parametrize("bus", [1, 3])
def test_bus_that_is_switched_off_is_an_error(bus: int, raises: Raises, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(number: int, **_settings: Any) -> None:
        raise ValueError(f"No device found for /dev/i2c-{number}")

    monkeypatch.setattr(extended_bus, "ExtendedI2C", refuse)
    with raises(DeviceError, "i2c-off"):
        BNO055(bus=bus).open(IMU, DeviceContext(load_robot("rover"), SteppedClock(1000, lambda _steps: None)))


def test_another_chip_at_its_address_is_refused(bench: Bench, raises: Raises) -> None:
    bench.chip.identity = bench.chip.registers[IDENTITY] = 0xB0
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


def test_notes_say_that_the_robot_must_stand_and_which_bus_is_reliable(check_text: CheckText) -> None:
    check_text("\n".join([*BNO055().notes(IMU), "", *BNO055(bus=3).notes(IMU)]))
