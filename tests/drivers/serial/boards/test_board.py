"""Rules of all boards, each with its double."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import pytest

from drivers.serial.backend import SECTION, SerialBackend
from drivers.serial.boards.board import BoardProtocol, CountAccumulator
from drivers.serial.boards.hoverboard.protocol import STOP as HOVERBOARD_STOP
from drivers.serial.boards.hoverboard.protocol import HoverboardProtocol
from drivers.serial.boards.rosarduino.board import ArduinoProtocol
from drivers.serial.boards.rosarduino.protocol import STOP_NOW
from drivers.serial.boards.sabertooth.protocol import build_stop_packets
from drivers.serial.boards.waveshare.protocol import STOP as WAVESHARE_STOP
from drivers.serial.boards.waveshare.protocol import WaveshareProtocol
from robotcore.description import load_robot
from robotcore.errors import DescriptionError, DeviceLostError
from robotcore.hal.backend import Setup
from robotcore.hal.cutoff import merge_cutoffs
from robotcore.hardware import bind_devices
from robotcore.kinds.encoder import Angle
from robotcore.kinds.motor import Motor
from tests.doubles.serial.bench import Devices, Rig, board_devices, connect_devices
from tests.doubles.serial.board import BoardDouble
from tests.doubles.serial.hoverboard import Hoverboard
from tests.doubles.serial.rosarduino import RobotcoreBridgeDouble, RosArduinoBridgeDouble
from tests.doubles.serial.sabertooth import Sabertooths
from tests.doubles.serial.waveshare import WaveshareBoard
from tests.drivers.serial.boards.conftest import OpenRig
from tests.texts import CheckText, Raises

MODEL = {"forward_rad_s": 16.0, "backward_rad_s": 16.0}
DRIVE = load_robot("rover").drive
assert DRIVE
WHEEL_M = 2 * DRIVE.wheel_radius_m


def sabertooths(**right: Any) -> Devices:
    """Return the tables of both motors, with other settings of the right motor."""
    motor = {"driver": "sabertooth-motor", "model": MODEL}
    return {"left_motor": {**motor, "motor": 1}, "right_motor": {**motor, "motor": 2, **right}}


@dataclass(frozen=True)
class Board:
    """A board: its double, its devices, its stop frame, its time-out in seconds and its battery's voltage in volts."""

    make: Callable[[], BoardDouble]
    devices: Devices
    stop: bytes
    timeout_s: float
    volts: float | None = None


BOARDS = {
    "robotcore_bridge": Board(
        lambda: RobotcoreBridgeDouble(counts_per_turn=3840),
        board_devices("ros-arduino", nose={}, battery={}),
        STOP_NOW,
        0.5,
        7.4,
    ),
    "ROSArduinoBridge": Board(
        lambda: RosArduinoBridgeDouble(3840), board_devices("ros-arduino", nose={"pin": 7}), STOP_NOW, 2.0
    ),
    "waveshare": Board(
        lambda: WaveshareBoard(WHEEL_M), board_devices("waveshare", battery={}), WAVESHARE_STOP, 0.5, 11.87
    ),
    "hoverboard": Board(
        Hoverboard, board_devices("hoverboard", {"mode": "speed"}, battery={}), HOVERBOARD_STOP, 0.8, 37.96
    ),
    "sabertooth": Board(Sabertooths, sabertooths(), build_stop_packets(128), 0.5),
}


@pytest.fixture(params=BOARDS)
def case(request: pytest.FixtureRequest) -> Board:
    return BOARDS[request.param]


@pytest.fixture
def board(case: Board) -> BoardDouble:
    return case.make()


@pytest.fixture
def rig(open_rig: OpenRig, board: BoardDouble, case: Board) -> Rig:
    return open_rig(board, case.devices)


def sensors(rig: Rig) -> Iterator[str]:
    return (name for name, device in rig.robot.devices.items() if not isinstance(device, Motor))


def test_wheels_turn_at_their_commands_and_encoders_agree(rig: Rig, board: BoardDouble) -> None:
    rig.drive(4.0, -3.0, 1.0)
    assert (board.wheels.left.velocity, board.wheels.right.velocity) == pytest.approx((4.0, -3.0), rel=0.05)
    if "left_encoder" in rig.robot.devices:
        turned = board.wheels.left.angle, board.wheels.right.angle
        assert (rig.angle("left"), rig.angle("right")) == pytest.approx(turned, abs=0.3)


def test_a_battery_is_reported_in_volts(rig: Rig, case: Board) -> None:
    if case.volts:
        assert rig.read("battery").voltage == pytest.approx(case.volts)


def test_the_board_stops_if_the_app_is_silent(rig: Rig, board: BoardDouble, case: Board) -> None:
    rig.drive(4.0, 4.0, 0.5)
    rig.pass_time(0.7 * case.timeout_s)
    assert board.wheels.left.velocity > 3
    rig.pass_time(case.timeout_s + 0.5)
    assert abs(board.wheels.left.velocity) < 0.01


def test_an_unplugged_board_is_lost_and_stands_until_a_new_command(
    rig: Rig, board: BoardDouble, case: Board, raises: Raises
) -> None:
    rig.drive(4.0, 4.0, 0.5)
    before = rig.angle("left") if "left_encoder" in rig.robot.devices else 0.0
    rig.pty.unplug()
    rig.pass_time(0.05)
    with raises(DeviceLostError, "port-lost", device="left_motor"):
        rig.motor("left").set_velocity(4.0)
    for name in sensors(rig):
        with pytest.raises(DeviceLostError):
            rig.read(name)
    rig.pass_time(case.timeout_s + 1.0)
    assert abs(board.wheels.left.velocity) < 0.01
    rig.pty.plug_in()
    for _ in range(300):
        rig.pass_time(0.01)
        assert abs(board.wheels.left.command) < 0.01
    if before:
        assert rig.angle("left") == pytest.approx(before, abs=0.5)  # it coasts
    rig.drive(4.0, 4.0, 0.5)
    assert board.wheels.left.velocity > 3


def test_a_board_that_falls_silent_is_lost(rig: Rig, case: Board, raises: Raises) -> None:
    if case.make is not Sabertooths:  # it never sends anything
        rig.drive(4.0, 4.0, 0.1)
        rig.powered.off()
        with raises(DeviceLostError, "board-silent", device="left_motor"):
            rig.drive(4.0, 4.0, 2.5)


def test_closing_stops_both_wheels(rig: Rig, board: BoardDouble) -> None:
    rig.drive(4.0, 4.0, 0.5)
    rig.robot.close()
    rig.pass_time(0.01)
    assert board.wheels.left.command == board.wheels.right.command == 0.0


def test_another_process_stops_both_wheels_after_a_cut_line(rig: Rig, board: BoardDouble, case: Board) -> None:
    rig.drive(4.0, 4.0, 0.1)
    [spec] = merge_cutoffs(rig.robot.cutoffs)
    assert spec.parameters["frame"] == case.stop.hex()
    if case.make is not Hoverboard:  # it needs the pause between two frames, which simulated time does not have
        cutoff = spec.make()
        cutoff.open()
        board.receive(case.stop[:9], rig.clock.now())
        cutoff.stop()
        cutoff.close()
        rig.pass_time(0.02)
        assert board.wheels.left.command == board.wheels.right.command == 0.0


def test_no_sample_from_before_a_loss_is_read_after_it(rig: Rig) -> None:
    names = list(sensors(rig))
    rig.pass_time(0.1)
    rig.pty.unplug()
    rig.pass_time(2.0)
    rig.pty.plug_in()
    back_at, read = rig.clock.now(), set()
    for _ in range(600):
        rig.pass_time(0.002)
        for name in names:
            with suppress(DeviceLostError):
                assert rig.read(name).time > back_at - 0.5, f"{name} at {rig.clock.now() - back_at:g} s"
                read.add(name)
    assert read == set(names)


def test_robotcore_stop_needs_no_open_device(case: Board) -> None:
    robot = connect_devices(case.devices)
    [spec] = merge_cutoffs(SerialBackend().cutoffs(Setup(robot, None, frozenset(case.devices))))
    assert (spec.parameters["frame"], spec.parameters["has_owner"]) == (case.stop.hex(), False)


PROTOCOLS: dict[str, tuple[Callable[[int], BoardProtocol], float]] = {
    "robotcore_bridge": (ArduinoProtocol, 20.0),
    "ROSArduinoBridge": (ArduinoProtocol, 20.0),
    "waveshare": (WaveshareProtocol, 0.2),
    "hoverboard": (HoverboardProtocol, 100.0),
}
"""The protocol of each board, and a command value that turns a motor."""


@pytest.mark.parametrize("name", PROTOCOLS)
def test_a_command_during_a_loss_turns_no_wheel_after_it(name: str) -> None:
    make, value = PROTOCOLS[name]
    protocol, board = make(57600), BOARDS[name].make()
    now, has_turned = 0.0, False
    protocol.begin(now)

    def pass_time(is_over: Callable[[], bool], *, is_cut: bool = False) -> None:
        nonlocal now, has_turned
        end = now + 3.0
        while not is_over() and now < end:
            now += 0.002
            received = board.live(now, 0.002)
            sent = protocol.data_to_send(now)
            if not is_cut:
                protocol.receive(received + board.receive(sent, now), now)
            has_turned |= bool(board.wheels.left.command)

    pass_time(lambda: protocol.is_ready)
    pass_time(lambda: not protocol.is_ready, is_cut=True)
    protocol.command.set("left", value, now)  # another thread has checked the line just before the loss
    pass_time(lambda: protocol.is_ready)
    pass_time(lambda: False)
    assert protocol.is_ready
    assert not has_turned
    protocol.command.set("left", value, now)
    pass_time(lambda: has_turned)
    assert has_turned


def test_the_shortest_time_out_of_all_motors_applies(check_text: CheckText) -> None:
    protocol = WaveshareProtocol(115200)
    check_text(protocol.timeout_notice)
    for seconds in (2.0, 0.3, 1.0):
        protocol.limit(seconds)
    assert protocol.timeout_s == 0.3


def test_ros_arduino_bridge_keeps_its_own_time_out() -> None:
    protocol = ArduinoProtocol(57600)
    protocol.limit(0.3)
    assert protocol.timeout_s == 2.0


def hoverboard(**motor: Any) -> Devices:
    return board_devices("hoverboard", motor)


def arduino(**motor: Any) -> Devices:
    return board_devices("ros-arduino", motor)


def with_right_motor(devices: Devices, **changes: Any) -> Devices:
    return {**devices, "right_motor": {**devices["right_motor"], **changes}}


SLOW_MODEL = {"forward_rad_s": 3.0, "backward_rad_s": 18.0}
REFUSED: dict[str, tuple[str, Devices]] = {
    "hoverboard-without-mode": ("missing-key", hoverboard()),
    "hoverboard-too-slow": ("setting-conflict", hoverboard(mode="speed", max_rpm=100)),
    "hoverboard-model-without-duty": ("setting-conflict", hoverboard(mode="speed", model=MODEL)),
    "hoverboard-duty-without-model": ("setting-conflict", hoverboard(mode="duty")),
    "hoverboard-weak-mixer": ("setting-conflict", hoverboard(mode="duty", model=MODEL, speed_coefficient=0.8)),
    "hoverboard-slow-model": ("setting-conflict", hoverboard(mode="duty", model=SLOW_MODEL)),
    "hoverboard-two-firmwares": ("pin-conflict", with_right_motor(hoverboard(mode="speed"), steer_coefficient=1.0)),
    "sabertooth-baud": ("setting-conflict", sabertooths(baud=57600)),
    "sabertooth-address": ("out-of-bounds", sabertooths(address=127)),
    "sabertooth-motor-twice": ("pin-conflict", sabertooths(motor=1)),
    "sabertooth-control-without-encoder": ("setting-conflict", sabertooths(control={})),
    "sabertooth-slow-model": ("setting-conflict", sabertooths(model=SLOW_MODEL)),
    "arduino-without-encoders": (
        "setting-conflict",
        {name: table for name, table in arduino().items() if "motor" in name},
    ),
    "arduino-encoder-on-another-port": ("setting-conflict", with_right_motor(arduino(), port="/dev/ttyACM3")),
    "arduino-control-without-model": ("setting-conflict", arduino(control={})),
    "arduino-trim-with-model": ("trim-with-model", arduino(model=MODEL, trim=1.1)),
    "arduino-one-side-twice": ("pin-conflict", with_right_motor(arduino(), side="left")),
}


@pytest.mark.parametrize("name", REFUSED)
def test_settings_beyond_a_board_are_refused_in_the_robots_file(name: str, raises: Raises) -> None:
    kind, devices = REFUSED[name]
    with raises(DescriptionError, kind):
        bind_devices(connect_devices(devices), SECTION)


@pytest.mark.parametrize(
    "board, fastest, counts",
    [("waveshare", 80.0, 960), ("ros-arduino", 12.0, 1), ("ros-arduino", 1000.0, 960)],
    ids=["waveshare-too-fast", "arduino-too-slow", "arduino-too-fast"],
)
def test_a_velocity_beyond_a_board_is_refused(board: str, fastest: float, counts: int, raises: Raises) -> None:
    robot = connect_devices(board_devices(board))
    changes: dict[str, dict[str, Any]] = {
        "motor": {"max_velocity_rad_s": fastest},
        "encoder": {"counts_per_turn": counts},
    }
    changed = tuple(device.model_copy(update=changes[device.kind]) for device in robot.devices)
    with raises(DescriptionError, "setting-conflict"):
        bind_devices(robot.model_copy(update={"devices": changed}), SECTION)


def test_a_waveshare_board_without_a_drive_is_refused(raises: Raises) -> None:
    with raises(DescriptionError, "setting-conflict"):
        bind_devices(connect_devices(board_devices("waveshare")).model_copy(update={"drive": None}), SECTION)


def test_a_counter_begins_at_zero_and_wraps_in_both_directions() -> None:
    for wraps_at, counts, total in [
        (None, [700], 0),
        (None, [700, 690], -10),
        (2**32, [2**31 - 5, -(2**31) + 5], 10),
        (2**32, [-(2**31) + 5, 2**31 - 5], -10),
    ]:
        counter = CountAccumulator(wraps_at)
        assert counter.angle(1.0) is None
        for time, count in enumerate(counts):
            counter.add(count, time)
        assert counter.angle(1.0) == Angle(total, len(counts) - 1, len(counts) - 1)


def test_the_angle_continues_after_a_reset_of_the_board() -> None:
    counter = CountAccumulator()
    for count in (0, 100):
        counter.add(count, 0.0)
    counter.restart()
    assert counter.angle(1.0) == Angle(100.0, 0.0, 1)
    for count in (3, 5):
        counter.add(count, 0.0)
    assert counter.angle(1.0) == Angle(102.0, 0.0, 3)
