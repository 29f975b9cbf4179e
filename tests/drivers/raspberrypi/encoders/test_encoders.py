"""Encoders on pins: reading from threads, and encoders with one channel."""

from __future__ import annotations

import math
import threading
from contextlib import ExitStack

import pytest

from drivers.raspberrypi.encoders import PinEncoder
from robotcore.errors import DescriptionError, DeviceError
from robotcore.hal.devices import Angle, Device, Motor
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import bind_devices
from tests.drivers.raspberrypi.encoders.wires import TURN, Wires
from tests.drivers.raspberrypi.motors.rig import Rig, rover
from tests.texts import Raises

AGES_S = 10.0
"""The time limit of a wait for a thread."""

OVERTAKES_S = 0.05
"""Enough time for a thread that is not blocked."""


class SlowCounter:
    """A counter whose first reading blocks."""

    def __init__(self) -> None:
        self.asked, self.release = threading.Event(), threading.Event()

    @property
    def edges(self) -> int:
        if not self.asked.is_set():
            self.asked.set()
            self.release.wait(AGES_S)
        return 0


def test_threads_that_read_at_once_get_samples_of_one_row() -> None:
    clock, counter, samples = MonotonicClock(), SlowCounter(), list[Angle]()
    encoder = PinEncoder("left_encoder", clock, counter, 4, ExitStack())
    threads = [threading.Thread(target=lambda: samples.append(encoder.read())) for _ in range(2)]
    threads[0].start()
    assert counter.asked.wait(AGES_S)
    threads[1].start()
    threads[1].join(OVERTAKES_S)
    counter.release.set()
    for thread in threads:
        thread.join(AGES_S)
    clock.close()
    assert [sample.sequence for sample in sorted(samples, key=lambda sample: sample.time)] == [0, 1]


PIN = 5
PULSES = {"driver": "pulses", "gpio": PIN}
EDGE = math.tau / TURN / 2


def test_a_turn_has_the_described_number_of_cycles() -> None:
    wires = Wires(PULSES)
    pulse(wires, TURN)
    assert wires.angle() == pytest.approx(math.tau)


def test_a_turn_has_the_described_number_of_edges() -> None:
    wires = Wires({**PULSES, "counts": "edges"})
    pulse(wires, TURN)
    assert wires.angle() == pytest.approx(2 * math.tau)


def test_it_counts_in_the_direction_of_the_motor_s_last_command() -> None:
    rig = Rig()
    wires = Wires(PULSES, opened={"left_motor": rig.motor})
    angles = []
    for command in (3.0, -3.0, 0.0, 3.0):  # a stopped wheel coasts
        rig.motor.set_velocity(command)
        pulse(wires, 1)
        angles.append(wires.angle())
    assert angles == pytest.approx([2 * EDGE, 0, -2 * EDGE, 0])


def test_the_motor_may_be_opened_after_the_encoder() -> None:
    wires = Wires(PULSES)
    rig = Rig()
    rig.motor.set_velocity(-3.0)
    wires.opened["left_motor"] = rig.motor
    pulse(wires, 1)
    assert wires.angle() == pytest.approx(-2 * EDGE)


def test_a_motor_that_reports_no_direction_is_an_error(raises: Raises) -> None:
    wires = Wires(PULSES, opened={"left_motor": MotorWithoutDirection("left_motor", 12.0)})
    pulse(wires, 1)
    with raises(DeviceError, "no-direction"):
        wires.encoder.read()


def test_an_encoder_on_no_wheel_of_the_drive_is_refused(raises: Raises) -> None:
    robot = rover({"left_encoder": PULSES}).model_copy(update={"drive": None})
    with raises(DescriptionError):
        bind_devices(robot, "raspberrypi", ["left_encoder"])


def test_closing_frees_the_pin() -> None:
    wires = Wires(PULSES)
    wires.opened["left_encoder"].close()
    opened: dict[str, Device] = {}
    Wires(PULSES, wires.pins, opened)


class MotorWithoutDirection(Motor):
    """A motor without a direction."""

    def _apply(self, rad_s: float) -> None:
        pass


def pulse(wires: Wires, cycles: int) -> None:
    for _ in range(cycles):
        wires.set(PIN, 0)
        wires.set(PIN, 1)
