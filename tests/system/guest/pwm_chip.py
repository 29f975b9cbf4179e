"""Motors on a PCA9685, by the kernel's transfers to the registers of its module i2c-stub.

Source: https://www.kernel.org/doc/html/v6.1/i2c/i2c-stub.html. Its registers only keep what is written. So those of the
channels do not follow the register that switches every channel off.
"""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import closing

import pytest

from drivers.raspberrypi.i2c_device import I2CDevice, ReservedChipError, find_bus
from drivers.raspberrypi.pwm.chip import ALL_CHANNELS, FIRST_CHANNEL, FULL_BIT, PRE_SCALE
from tests.system.guest.bench import ENDLESS_DRIVE, run_command, start_process, wait_until
from tests.system.guest.chip import Chip
from tests.system.speed import scaled

ADDRESS = 0x60
M1, M2 = 8, 13
ALL_OFF = ALL_CHANNELS + 3
LIMIT_S = 12


@pytest.fixture
def registers(chip: Chip) -> Iterator[I2CDevice]:
    with closing(I2CDevice(find_bus(1), ADDRESS)) as device:
        device.write(PRE_SCALE, 0x1E)  # as after power-on: a PCA9685 never has 0
        device.write(ALL_OFF, 0)
        for channel in (M1, M2):
            device.write(FIRST_CHANNEL + 4 * channel, 0, 0, 0, FULL_BIT)
        yield device


def read_count(registers: I2CDevice, channel: int) -> int:
    """Return the count at which a channel falls; 0 if it is off."""
    low, high = (registers.read(FIRST_CHANNEL + 4 * channel + at) for at in (2, 3))
    return 0 if high & FULL_BIT else low | high << 8


def test_the_kernel_writes_a_byte_and_a_block_and_reads_a_byte(registers: I2CDevice) -> None:
    registers.write(FIRST_CHANNEL, 1, 2, 3, 4)
    registers.write(FIRST_CHANNEL + 1, 5)
    assert [registers.read(FIRST_CHANNEL + at) for at in range(4)] == [1, 5, 3, 4]


def test_an_address_without_a_chip_is_an_error(registers: I2CDevice) -> None:
    with closing(I2CDevice(find_bus(1), 0x41)) as absent, pytest.raises(OSError, match="No such device"):
        absent.read(0)


def test_a_chip_is_reserved_for_one_program_until_it_closes_the_chip(registers: I2CDevice) -> None:
    with closing(I2CDevice(find_bus(1), ADDRESS)) as device, closing(I2CDevice(find_bus(1), 0x41)) as other:
        device.reserve()
        other.reserve()
        assert registers.is_reserved()
        with pytest.raises(ReservedChipError):
            registers.reserve()
    assert not registers.is_reserved()


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_motors_of_a_run_that_is_ended_are_off(registers: I2CDevice, number: int) -> None:
    with start_process(run_command(ENDLESS_DRIVE, "pwm_chip")) as app:
        assert wait_until(lambda: bool(read_count(registers, M1) and read_count(registers, M2)), True)
        registers.write(ALL_OFF, 0)
        app.send_signal(number)
        app.wait(scaled(LIMIT_S))
        assert wait_until(lambda: registers.read(ALL_OFF), FULL_BIT) == FULL_BIT


def test_motors_of_a_suspended_run_are_off(registers: I2CDevice) -> None:
    with start_process(run_command(ENDLESS_DRIVE, "pwm_chip")) as app:
        assert wait_until(lambda: bool(read_count(registers, M1) and read_count(registers, M2)), True)
        app.send_signal(signal.SIGSTOP)
        assert wait_until(lambda: read_count(registers, M1) + read_count(registers, M2), 0) == 0
        app.send_signal(signal.SIGCONT)
