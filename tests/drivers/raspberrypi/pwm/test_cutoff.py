"""The cutoff of motors on a PCA9685, with programs that live or were killed."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator

import pytest

from drivers.raspberrypi.pwm.cutoff import ChannelCutoff
from robotcore.errors import BackendError
from robotcore.hardware import bind_devices
from tests.drivers.raspberrypi.i2c_dev import ADDRESS, Bus
from tests.drivers.raspberrypi.pwm.robots import LEFT, PAN, build_context, build_robot, open_devices
from tests.texts import Raises

MOTOR, SERVO = 8, 15


@pytest.fixture
def owner() -> Iterator[subprocess.Popen[bytes]]:
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as program:
        yield program
        program.kill()


@pytest.fixture
def driving(bus: Bus) -> Bus:
    """Return a bus on which a motor turns and a servo holds."""
    robot = build_robot(left_motor={**LEFT, "frequency_hz": 50}, pan=PAN)
    motor, _ = open_devices(robot, build_context(robot))
    motor.set_velocity(5.0)
    assert all(bus.duties()[channel] for channel in (MOTOR, SERVO))
    return bus


def open_cutoff(owner: int | None) -> ChannelCutoff:
    cutoff = ChannelCutoff(1, ADDRESS, [8, 10, 9], owner)
    cutoff.open()
    return cutoff


def test_opening_and_closing_a_cutoff_changes_no_channel(driving: Bus) -> None:
    before = driving.registers
    cutoff = open_cutoff(None)
    cutoff.close()
    assert driving.registers == before


def test_motor_of_a_live_program_stops_and_its_servo_holds(driving: Bus, owner: subprocess.Popen[bytes]) -> None:
    cutoff = open_cutoff(owner.pid)
    cutoff.stop()
    assert [channel for channel, duty in enumerate(driving.duties()) if duty] == [SERVO]
    assert owner.poll() is None


def test_every_channel_of_a_killed_program_is_off(driving: Bus, owner: subprocess.Popen[bytes]) -> None:
    cutoff = open_cutoff(owner.pid)
    owner.kill()
    owner.wait()
    cutoff.stop()
    assert set(driving.duties()) == {0.0}
    cutoff.close()


def test_robotcore_stop_stops_the_motor_of_a_live_run_and_names_it(driving: Bus, raises: Raises) -> None:
    with raises(BackendError, "chip-held"):
        open_cutoff(None).stop()
    assert [channel for channel, duty in enumerate(driving.duties()) if duty] == [SERVO]


def test_robotcore_stop_stops_the_motors_of_a_dead_run(bus: Bus) -> None:
    bus.switch_on()
    cutoff = open_cutoff(None)
    cutoff.stop()
    assert set(bus.duties()) == {0.0}
    cutoff.close()


def test_chip_that_does_not_answer_raises_so_that_the_guardian_tries_again(driving: Bus) -> None:
    cutoff = open_cutoff(None)
    driving.unplug()
    with pytest.raises(OSError, match="Remote I/O"):
        cutoff.stop()


def test_driver_gives_the_guardian_the_channels_of_its_motor() -> None:
    robot = build_robot(left_motor=LEFT)
    (binding,) = bind_devices(robot, "raspberrypi")
    (spec,) = binding.driver.cutoffs(binding.description, build_context(robot, owner=12))
    assert spec.parameters == {"bus": 1, "address": 0x60, "channels": [8, 10, 9], "owner": 12}
