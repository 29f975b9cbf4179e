"""A TFmini on a line keeps the kit's rules; a simulator is in front of it, and the rest of the robot is its own."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import pytest

from drivers.kinematic.backend import KinematicBackend
from drivers.serial.ranging.tfmini import TFmini, TFminiSettings
from robotcore.description import RobotDescription, load_robot
from robotcore.errors import DescriptionError, DeviceError, DeviceLostError
from robotcore.hal.backend import Setup
from robotcore.hal.devices import RangeSensor
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import Host, bind_devices, open_robot
from robotcore.testing import TestSupport
from robotcore.testing.lifecycle_rules import LifecycleRules
from robotcore.testing.range_rules import RangeRules
from robotcore.testing.time_rules import SampleRules
from tests.doubles.serial.board import Powered
from tests.doubles.serial.pty import Pty
from tests.doubles.serial.tfmini import DAZZLED_CM, PERIOD_S, REACH_M, WEAK, WEAK_CM, TFminiS, frame
from tests.drivers.serial.ranging.rig import NOSE, Rig, robot_with

WIRE = {"driver": "tfmini", "port": "/dev/ttyUSB0"}
DARK, DAZZLED = frame(WEAK_CM, WEAK), frame(DAZZLED_CM)


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    rig = Rig(tmp_path)
    yield rig
    rig.close()


def test_a_sample_is_in_hand_when_it_is_open(rig: Rig) -> None:
    assert rig.open().read().distance == 0.5


def test_each_frame_is_a_new_sample_of_when_it_arrived(rig: Rig) -> None:
    sensor = rig.open()
    before = sensor.read()
    rig.sends(frame(120), cycles=5)
    after = sensor.read()
    assert (after.distance, after.sequence) == (1.2, before.sequence + 5)
    assert after.time == pytest.approx(before.time + 0.05)
    assert rig.clock.now() - after.time < 0.01


def test_the_newest_of_frames_that_come_at_once_counts(rig: Rig) -> None:
    sensor = rig.open()
    before = sensor.read()
    rig.sends(frame(60), frame(70), frame(80), cycles=1)
    assert (sensor.read().distance, sensor.read().sequence) == (0.8, before.sequence + 1)


def test_a_sensor_that_falls_silent_grows_old_and_is_lost_by_name_until_it_speaks_again(rig: Rig) -> None:
    sensor = rig.open()
    before = sensor.read()
    rig.sends(cycles=30)
    assert sensor.read() == before
    rig.sends(cycles=20)
    with pytest.raises(DeviceLostError, match=r"nose: nothing comes on .*board at 115200 baud; look at its 5 V"):
        sensor.read()
    rig.sends(frame(70), cycles=3)
    assert (sensor.read().distance, sensor.read().time > before.time) == (0.7, True)


def test_nothing_is_vouched_for_only_after_a_row_of_dark_frames(rig: Rig) -> None:
    sensor = rig.open(echo_free_cycles=10)
    before = sensor.read()
    rig.sends(DARK, cycles=9)
    assert sensor.read() == before
    rig.cycles()
    assert sensor.read().distance == math.inf


@pytest.mark.parametrize("between", [DAZZLED, frame(50)], ids=["too much light", "a target"])
def test_what_is_seen_between_dark_frames_begins_their_row_anew(rig: Rig, between: bytes) -> None:
    sensor = rig.open(echo_free_cycles=10)
    for _ in range(5):
        rig.sends(DARK, cycles=8)
        rig.sends(between, DARK, cycles=1)
    assert sensor.read().distance == 0.5


def test_too_much_light_is_no_sample(rig: Rig) -> None:
    sensor = rig.open()
    before = sensor.read()
    rig.sends(DAZZLED, cycles=200)
    assert sensor.read() == before


@pytest.mark.parametrize("centimetres, expected", [(201, math.inf), (1200, math.inf), (3, 0.1), (0, 0.1)])
def test_distances_out_of_range_read_as_every_range_sensors(rig: Rig, centimetres: int, expected: float) -> None:
    sensor = rig.open()
    rig.sends(frame(centimetres), cycles=1)
    assert sensor.read().distance == expected


def test_dark_at_the_opening_is_reported_where_nothing_may_vouch_for_it(rig: Rig) -> None:
    rig.sends(DARK)
    with pytest.raises(DeviceError, match="nose: has found nothing that could be judged"):
        rig.open(echo_free_cycles=0)
    assert rig.open().read().distance == math.inf


def test_a_wrong_speed_is_reported_by_what_comes_in_place_of_frames(rig: Rig) -> None:
    rig.sends(random.Random(1).randbytes(9))
    with pytest.raises(
        DeviceError,
        match=r"nose: \d+ bytes came on .*board at 9600 baud, and no frame of a TFmini. Set baud to .*115200",
    ):
        rig.open(baud=9600)


def test_a_sensor_that_says_nothing_is_refused_with_what_to_look_at(rig: Rig) -> None:
    rig.sends()
    with pytest.raises(DeviceError, match=r"nose: nothing comes on .*board at 115200 baud; look at its 5 V"):
        rig.open()


def test_a_port_that_is_not_there_is_not_taken_for_a_silent_one(rig: Rig) -> None:
    rig.sends()
    rig.pty.unplug()
    with pytest.raises(DeviceError, match=r"nose: there is no .*board"):
        rig.open()


def test_nothing_is_ever_sent_to_it(rig: Rig) -> None:
    rig.open().close()
    assert rig.pty.heard() == b""


def test_what_waited_in_a_full_buffer_is_of_an_unknown_age(rig: Rig) -> None:
    sensor = rig.open()
    before = sensor.read()
    rig.sends(*[frame(90)] * 455, cycles=1)
    assert sensor.read() == before
    rig.sends(frame(95), cycles=1)
    assert sensor.read().distance == 0.95


def test_unplugged_it_is_lost_by_name_and_plugged_in_it_is_back(rig: Rig) -> None:
    sensor = rig.open()
    before = sensor.read()
    rig.pty.unplug()
    rig.cycles(5)
    with pytest.raises(DeviceLostError, match=r"nose: .*board is gone"):
        sensor.read()
    rig.pty.plug_in()
    rig.sends(cycles=20)
    with pytest.raises(DeviceLostError, match=r"nose: nothing comes on .*board"):
        sensor.read()
    rig.sends(DARK, cycles=2)
    with pytest.raises(DeviceLostError, match=r"nose: the board on .* is back, and has not told anything of it yet"):
        sensor.read()
    rig.sends(frame(70), cycles=1)
    after = sensor.read()
    assert (after.distance, after.sequence) == (0.7, before.sequence + 1)


def test_a_thread_hears_it_at_the_machines_own_time(tmp_path: Path) -> None:
    clock = MonotonicClock()
    with Pty(tmp_path) as pty:
        talking = clock.every(PERIOD_S, lambda: pty.say(frame(50)), "TFmini")
        sensor = TFmini().open(NOSE, TFminiSettings(port=str(pty.path)), Host(load_robot("rover"), clock))
        before = sensor.read()
        for _ in range(5000):
            if sensor.read().sequence > before.sequence:
                break
            clock.sleep_until(clock.now() + 0.001)
        assert sensor.read().distance == 0.5
        assert before.time < sensor.read().time <= clock.now()
        sensor.close()
        talking.stop()
    clock.close()


@pytest.mark.parametrize(
    "changes, settings, fault",
    [
        ({"max_range_m": 9.0}, {}, r"a TF-Luna sees as far as 8 m, and max_range_m is 9\. Lower it"),
        ({"min_range_m": 0.02}, {}, r"nearer than 0\.1 m .* and min_range_m is 0\.02\. Raise it"),
        ({}, {"cycle_s": 0.02}, r"echo_free_cycles of cycle_s take 1\.2 s"),
    ],
)
def test_what_it_cannot_do_is_refused_by_the_robots_file(
    changes: dict[str, float], settings: dict[str, float], fault: str
) -> None:
    robot = robot_with(NOSE.model_copy(update=changes), nose=WIRE | settings)
    with pytest.raises(DescriptionError, match=fault):
        bind_devices(robot, "serial", {"nose"})


def test_two_on_one_port_are_refused() -> None:
    robot = robot_with(NOSE, NOSE.model_copy(update={"name": "tail"}), nose=WIRE, tail=WIRE)
    with pytest.raises(
        DescriptionError, match=r"serial /dev/ttyUSB0 is already serial\.nose\.port, where TFmini at 115200"
    ):
        bind_devices(robot, "serial", {"nose", "tail"})


@pytest.mark.conformance
class TestTFmini(LifecycleRules, RangeRules, SampleRules):
    backend = KinematicBackend
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: "reading never asks the line: it talks by itself"}

    @pytest.fixture(autouse=True)
    def _folder(self, tmp_path: Path) -> None:
        self._path = tmp_path

    @property
    def description(self) -> RobotDescription:
        return robot_with(NOSE, nose={"driver": "tfmini", "port": str(self._path / "board")})

    def open(self, setup: Setup) -> Robot:
        seen = robot_with(NOSE.model_copy(update={"max_range_m": REACH_M}))
        with ExitStack() as undo:
            simulated = undo.enter_context(KinematicBackend().open(replace(setup, robot=seen)))
            pty = undo.enter_context(Pty(self._path))
            self.double = TFminiS(_distance(simulated))
            undo.callback(Powered(self.double, pty, simulated.clock).off)
            release = undo.pop_all().close
        others = {name: device for name, device in simulated.devices.items() if not isinstance(device, RangeSensor)}
        return open_robot(setup, "serial", simulated.clock, release=release, truth=simulated.truth, opened=others)

    def lose_echoes(self, robot: Robot) -> None:
        self.double.is_blind = True


def _distance(simulated: Robot) -> Callable[[], float]:
    """Return how far away what is in front of the robot is; nobody asks where it has no range sensor open."""
    noses = [device for device in simulated.devices.values() if isinstance(device, RangeSensor)]
    return lambda: noses[0].read().distance if noses else math.inf
