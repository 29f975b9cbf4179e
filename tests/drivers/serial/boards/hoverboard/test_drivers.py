"""A hoverboard's devices pass the conformance kit, with each mode and mixer of its firmware."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, ClassVar

import pytest

from drivers.serial.boards.hoverboard.protocol import STOP
from robotcore.description import BatteryDescription, load_robot
from robotcore.errors import DescriptionError, DeviceGroupError, DeviceLostError
from robotcore.hardware import Host, bind_devices
from robotcore.testing import ConformanceSuite
from tests.doubles.serial.bench import Rig, TickingBench, connect_devices
from tests.doubles.serial.board import BoardDouble, Wheels
from tests.doubles.serial.hoverboard import Firmware, Hoverboard
from tests.robotcore.testing.variant_suites import DriveSuite
from tests.texts import Raises

SIDES = ("left", "right")
FULL_RAD_S = 40.0


def devices(**motor: Any) -> dict[str, dict[str, Any]]:
    """Return the tables of both motors, both encoders and the battery."""
    motors = {f"{side}_motor": {"driver": "hoverboard-motor", "side": side, **motor} for side in SIDES}
    encoders = {f"{side}_encoder": {"driver": "hoverboard-encoder", "side": side} for side in SIDES}
    return {**motors, **encoders, "battery": {"driver": "hoverboard-battery"}}


class TestHoverboardHoldingSpeed(TickingBench, ConformanceSuite):
    devices: ClassVar = devices(mode="speed")
    extra: ClassVar = (BatteryDescription(kind="battery", name="battery"),)

    def board(self) -> BoardDouble:
        return Hoverboard(Wheels())


class TestHoverboardByDuty(TickingBench, DriveSuite):
    devices: ClassVar = devices(
        mode="duty", tank_steering=True, model={"forward_rad_s": FULL_RAD_S, "backward_rad_s": FULL_RAD_S}
    )
    extra: ClassVar = (BatteryDescription(kind="battery", name="battery"),)

    def board(self) -> BoardDouble:
        return Hoverboard(Wheels(), Firmware(is_tank=True, rad_s_per_unit=FULL_RAD_S / 1000))


BATTERY = BatteryDescription(kind="battery", name="battery")
MODEL = {"forward_rad_s": FULL_RAD_S, "backward_rad_s": FULL_RAD_S}


class Robots:
    """Opens robots, and closes all of them."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._rigs = folder, ExitStack()

    def on(self, board: Hoverboard, **motor: Any) -> Rig:
        rig = Rig(self._folder, board, devices(**motor), (BATTERY,))
        self._rigs.callback(rig.close)
        return rig

    def close(self) -> None:
        self._rigs.close()


@pytest.fixture
def robots(tmp_path: Path) -> Iterator[Robots]:
    opened = Robots(tmp_path)
    yield opened
    opened.close()


def test_wheels_turn_at_their_commands_and_encoders_agree(robots: Robots) -> None:
    board = Hoverboard(Wheels())
    rig = robots.on(board, mode="speed")
    rig.drive(4.0, -2.0, 1.0)
    assert board.wheels.left.velocity == pytest.approx(4.0, rel=0.02)
    assert board.wheels.right.velocity == pytest.approx(-2.0, rel=0.05)
    assert rig.angle("left") == pytest.approx(board.wheels.left.angle, abs=0.05)
    assert rig.angle("right") == pytest.approx(board.wheels.right.angle, abs=0.05)
    assert board.ignored == 0


def test_a_board_built_for_another_rpm_is_reported_with_the_measured_factor(robots: Robots) -> None:
    board = Hoverboard(Wheels(), Firmware(rad_s_per_unit=0.5 * Firmware().rad_s_per_unit))
    robots.on(board, mode="speed", max_rpm=500).drive(4.0, 4.0, 1.0)
    assert board.wheels.left.velocity == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize("motor", [{"mode": "speed"}, {"mode": "duty", "model": MODEL}], ids=["speed", "duty"])
def test_an_inverted_motor_turns_the_other_way(robots: Robots, motor: dict[str, Any]) -> None:
    board = Hoverboard(Wheels())
    robots.on(board, **motor, inverted=True).drive(4.0, 4.0, 0.5)
    assert board.wheels.left.velocity < 0 > board.wheels.right.velocity


def test_a_wheel_with_a_wrong_model_is_controlled_by_the_measured_speed(robots: Robots) -> None:
    board = Hoverboard(Wheels(), Firmware(is_tank=True, rad_s_per_unit=FULL_RAD_S / 1500))
    rig = robots.on(board, mode="duty", model=MODEL, tank_steering=True, control={})
    rig.drive(8.0, 4.0, 2.0)
    assert board.wheels.left.velocity == pytest.approx(8.0, rel=0.05)
    assert board.wheels.right.velocity == pytest.approx(4.0, rel=0.05)


def test_opposite_wheels_beyond_the_mixer_are_slowed_down_equally(robots: Robots) -> None:
    board = Hoverboard(Wheels(), Firmware(rad_s_per_unit=FULL_RAD_S / 1000))
    rig = robots.on(board, mode="duty", model={"forward_rad_s": 18.0, "backward_rad_s": 18.0})
    rig.drive(12.0, -12.0, 1.0)
    assert board.received[-1] == (1000, 0)
    rig.drive(12.0, -6.0, 1.0)
    assert board.wheels.right.velocity == pytest.approx(-board.wheels.left.velocity / 2, rel=0.01)


def test_an_app_that_is_silent_is_stopped_by_the_board(robots: Robots) -> None:
    board = Hoverboard(Wheels())
    rig = robots.on(board, mode="speed")
    rig.drive(4.0, 4.0, 0.5)
    rig.pass_time(0.7)
    assert board.wheels.left.velocity > 3
    rig.pass_time(1.0)
    assert abs(board.wheels.left.velocity) < 0.01


def test_a_lost_port_is_reported_and_its_motors_stand_and_keep_their_angles_after_replugging(
    robots: Robots, raises: Raises
) -> None:
    board = Hoverboard(Wheels())
    rig = robots.on(board, mode="speed")
    rig.drive(4.0, 4.0, 0.5)
    before = rig.angle("left")
    rig.pty.unplug()
    rig.pass_time(0.05)
    with raises(DeviceLostError, "port-lost", device="left_motor"):
        rig.motor("left").set_velocity(4.0)
    with raises(DeviceLostError, "port-lost", device="left_encoder"):
        rig.angle("left")
    rig.pass_time(2.0)
    assert abs(board.wheels.left.velocity) < 0.01
    rig.pty.plug_in()
    board.received.clear()
    rig.pass_time(3.0)
    assert set(board.received) == {(0, 0)}
    assert rig.angle("left") == pytest.approx(before, abs=0.3)
    rig.drive(4.0, 4.0, 0.5)
    assert board.wheels.left.velocity == pytest.approx(4.0, rel=0.02)


def test_a_silent_board_is_lost_although_its_port_is_open(robots: Robots, raises: Raises) -> None:
    board = Hoverboard(Wheels())
    rig = robots.on(board, mode="speed")
    rig.drive(4.0, 4.0, 0.5)
    board.is_mute = True
    with raises(DeviceLostError, "board-silent", device="left_motor"):
        rig.drive(4.0, 4.0, 1.0)
    board.is_mute = False
    rig.pass_time(0.2)
    assert board.received[-1] == (0, 0)
    rig.drive(4.0, 4.0, 0.5)


def test_a_silent_board_is_refused(robots: Robots, raises: Raises) -> None:
    board = Hoverboard(Wheels())
    board.is_mute = True
    with raises(DeviceGroupError):
        _ = robots.on(board, mode="speed").robot


def test_closing_waits_until_the_board_has_received_the_stop(robots: Robots) -> None:
    board = Hoverboard(Wheels())
    rig = robots.on(board, mode="speed")
    rig.drive(4.0, 4.0, 0.5)
    rig.robot.close()
    assert board.received[-1] == (0, 0)


def test_another_process_stops_both_wheels_by_one_frame() -> None:
    robot = connect_devices(load_robot("rover"), devices(mode="speed"), Path("/dev/ttyUSB0"), (BATTERY,))
    bindings = bind_devices(robot, "serial")
    specs = [spec for each in bindings for spec in each.cutoffs(Host(robot, owner=None, clock=None))]  # type: ignore[arg-type]
    assert [spec.parameters["frame"] for spec in specs] == [STOP.hex()] * 2


REFUSED: dict[str, dict[str, Any]] = {
    "no-mode": {},
    "too-slow-a-board": {"mode": "speed", "max_rpm": 100},
    "model-without-duty": {"mode": "speed", "model": MODEL},
    "duty-without-model": {"mode": "duty"},
    "weak-mixer": {"mode": "duty", "model": MODEL, "speed_coefficient": 0.8},
    "too-slow-a-model": {
        "mode": "duty",
        "model": {"forward_rad_s": 3.0, "backward_rad_s": 18.0},
    },
}


@pytest.mark.parametrize("case", REFUSED)
def test_settings_beyond_the_board_are_refused_in_the_robots_file(case: str, raises: Raises) -> None:
    robot = connect_devices(load_robot("rover"), devices(**REFUSED[case]), Path("/dev/ttyUSB0"), (BATTERY,))
    with raises(DescriptionError, "missing-key" if case == "no-mode" else "description"):
        bind_devices(robot, "serial")


def test_two_motors_with_different_settings_of_one_firmware_are_refused(raises: Raises) -> None:
    sections = devices(mode="speed")
    sections["right_motor"]["steer_coefficient"] = 1.0
    robot = connect_devices(load_robot("rover"), sections, Path("/dev/ttyUSB0"), (BATTERY,))
    with raises(DescriptionError):
        bind_devices(robot, "serial")
