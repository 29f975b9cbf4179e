"""A TFmini passes the conformance kit in a simulator's world; the other devices are the simulator's."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import pytest

from drivers.kinematic.backend import KinematicBackend
from drivers.serial.ranging.tfmini import TFmini
from robotcore.description import RobotDescription, load_robot
from robotcore.errors import DescriptionError, DeviceError, DeviceLostError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.robot import Robot
from robotcore.hardware import DeviceContext, bind_devices, open_robot
from robotcore.kinds.range_sensor import RangeSensor, RangeSensorDescription
from robotcore.testing import TestSupport
from robotcore.testing.lifecycle_rules import LifecycleRules
from robotcore.testing.range_rules import RangeRules
from robotcore.testing.time_rules import SampleRules
from tests.doubles.serial.board import Powered
from tests.doubles.serial.pty import Pty
from tests.doubles.serial.tfmini import DAZZLED_CM, PERIOD_S, REACH_M, WEAK, WEAK_CM, TFminiS, frame
from tests.texts import Raises

_NOSE = next(device for device in load_robot("rover").devices if isinstance(device, RangeSensorDescription))
NOSE = _NOSE.model_copy(update={"min_range_m": 0.1, "cone_rad": 0.063})
"""A beam of 3.6 degrees."""


def robot_with(*noses: RangeSensorDescription, **wires: Mapping[str, Any]) -> RobotDescription:
    """Return the rover with these range sensors in place of its own, and with these tables in [serial]."""
    rover = load_robot("rover")
    others = [device for device in rover.devices if not isinstance(device, RangeSensorDescription)]
    return rover.model_copy(update={"devices": (*others, *noses), "backends": {"serial": wires}})


class Rig:
    """A sensor that sends the distance 0.5 m until `set_frames` changes its frames."""

    def __init__(self, folder: Path) -> None:
        self.pty, self.clock, self.double = Pty(folder), SteppedClock(500, lambda _steps: None), TFminiS()
        self.set_frames(frame(50))
        self._opened = ExitStack()
        self._opened.enter_context(self.pty)
        self._opened.callback(Powered(self.double, self.pty, self.clock).off)

    def open(self, **settings: Any) -> RangeSensor:
        host = DeviceContext(load_robot("rover"), self.clock)
        sensor = TFmini(port=str(self.pty.path), **settings).open(NOSE, host)
        self._opened.callback(sensor.close)
        return sensor

    def set_frames(self, *frames: bytes, cycles: int = 0) -> None:
        """Set the frames that the sensor sends together in each cycle of 10 ms; let ``cycles`` cycles pass."""
        self.double.replacement = b"".join(frames)
        self.cycles(cycles)

    def cycles(self, count: int = 1) -> None:
        self.clock.sleep_until(self.clock.now() + PERIOD_S * count)

    def close(self) -> None:
        self._opened.close()


WIRE = {"driver": "tfmini", "port": "/dev/ttyUSB0"}
DARK, DAZZLED = frame(WEAK_CM, WEAK), frame(DAZZLED_CM)


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    rig = Rig(tmp_path)
    yield rig
    rig.close()


def test_each_frame_is_a_sample_with_its_arrival_time(rig: Rig) -> None:
    sensor = rig.open()
    before = sensor.read()
    rig.set_frames(frame(120), cycles=5)
    after = sensor.read()
    assert (after.distance, after.sequence) == (1.2, before.sequence + 5)
    assert after.time == pytest.approx(before.time + 0.05)
    assert rig.clock.now() - after.time < 0.01


def test_the_newest_of_frames_that_come_at_once_counts(rig: Rig) -> None:
    sensor = rig.open()
    before = sensor.read()
    rig.set_frames(frame(60), frame(70), frame(80), cycles=1)
    assert (sensor.read().distance, sensor.read().sequence) == (0.8, before.sequence + 1)


def test_a_sensor_that_falls_silent_is_lost_until_its_next_frames(rig: Rig, raises: Raises) -> None:
    sensor = rig.open()
    before = sensor.read()
    rig.set_frames(cycles=30)
    assert sensor.read() == before
    rig.set_frames(cycles=20)
    with raises(DeviceLostError, "board-silent", device="nose"):
        sensor.read()
    rig.set_frames(frame(70), cycles=3)
    assert (sensor.read().distance, sensor.read().time > before.time) == (0.7, True)


def test_only_a_row_of_dark_frames_means_nothing_in_range(rig: Rig) -> None:
    sensor = rig.open(echo_free_cycles=10)
    before = sensor.read()
    rig.set_frames(DARK, cycles=9)
    assert sensor.read() == before
    rig.cycles()
    assert sensor.read().distance == math.inf


@pytest.mark.parametrize("between", [DAZZLED, frame(50)], ids=["too much light", "a target"])
def test_another_frame_restarts_the_row_of_dark_frames(rig: Rig, between: bytes) -> None:
    sensor = rig.open(echo_free_cycles=10)
    for _ in range(5):
        rig.set_frames(DARK, cycles=8)
        rig.set_frames(between, DARK, cycles=1)
    assert sensor.read().distance == 0.5


def test_too_much_light_is_no_sample(rig: Rig) -> None:
    sensor = rig.open()
    before = sensor.read()
    rig.set_frames(DAZZLED, cycles=200)
    assert sensor.read() == before


def test_dark_at_the_opening_is_an_error_without_echo_free_cycles(rig: Rig, raises: Raises) -> None:
    rig.set_frames(DARK)
    with raises(DeviceError, "no-sample-yet", device="nose"):
        rig.open(echo_free_cycles=0)
    assert rig.open().read().distance == math.inf


def test_a_wrong_speed_is_reported_by_the_bytes_without_frames(rig: Rig, raises: Raises) -> None:
    rig.set_frames(random.Random(1).randbytes(9))
    with raises(DeviceError, "board-silent", device="nose"):
        rig.open(baud=9600)


def test_the_driver_sends_nothing(rig: Rig) -> None:
    rig.open().close()
    assert rig.pty.read() == b""


def test_frames_from_a_full_buffer_make_no_sample(rig: Rig) -> None:
    sensor = rig.open()
    before = sensor.read()
    rig.set_frames(*[frame(90)] * 455, cycles=1)
    assert sensor.read() == before
    rig.set_frames(frame(95), cycles=1)
    assert sensor.read().distance == 0.95


def test_an_unplugged_sensor_is_lost_and_works_after_replugging(rig: Rig, raises: Raises) -> None:
    sensor = rig.open()
    before = sensor.read()
    rig.pty.unplug()
    rig.cycles(5)
    with raises(DeviceLostError, "port-lost", device="nose"):
        sensor.read()
    rig.pty.plug_in()
    rig.set_frames(cycles=20)
    with raises(DeviceLostError, "board-silent", device="nose"):
        sensor.read()
    rig.set_frames(DARK, cycles=2)
    with raises(DeviceLostError, "no-sample-yet", device="nose"):
        sensor.read()
    rig.set_frames(frame(70), cycles=1)
    after = sensor.read()
    assert (after.distance, after.sequence) == (0.7, before.sequence + 1)


@pytest.mark.parametrize(
    "changes, settings",
    [({"max_range_m": 9.0}, {}), ({"min_range_m": 0.02}, {}), ({}, {"cycle_s": 0.02})],
    ids=["too-far", "too-near", "too-slow"],
)
def test_settings_beyond_the_sensor_are_refused_in_the_robots_file(
    changes: dict[str, float], settings: dict[str, float], raises: Raises
) -> None:
    robot = robot_with(NOSE.model_copy(update=changes), nose=WIRE | settings)
    with raises(DescriptionError, "setting-conflict"):
        bind_devices(robot, "serial", {"nose"})


def test_two_sensors_on_one_port_are_refused(raises: Raises) -> None:
    robot = robot_with(NOSE, NOSE.model_copy(update={"name": "tail"}), nose=WIRE, tail=WIRE)
    with raises(DescriptionError, "pin-conflict"):
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
        bindings = bind_devices(setup.robot, "serial", setup.devices - others.keys())
        return open_robot(setup, bindings, simulated.clock, release=release, truth=simulated.truth, opened=others)

    def lose_echoes(self, robot: Robot) -> None:
        self.double.is_blind = True


def _distance(simulated: Robot) -> Callable[[], float]:
    """Return a function for the distance ahead; `inf` if the simulator has no range sensor open."""
    noses = [device for device in simulated.devices.values() if isinstance(device, RangeSensor)]
    return lambda: noses[0].read().distance if noses else math.inf
