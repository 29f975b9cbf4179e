"""A rover on a Waveshare UGV board passes the conformance kit in simulated time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import ClassVar

import pytest

from drivers.serial.backend import SerialBackend
from drivers.serial.boards.waveshare.board import SILENCE_S, Odometer, WaveshareProtocol
from drivers.serial.boards.waveshare.drivers import WaveshareDriver
from drivers.serial.boards.waveshare.protocol import Track, speeds
from robotcore.description import BatteryDescription
from robotcore.errors import DescriptionError, DeviceError, DeviceGroupError, DeviceLostError
from robotcore.hal.cutoff import merge_cutoffs
from robotcore.testing import ConformanceSuite
from tests.doubles.serial.bench import SerialBench
from tests.doubles.serial.waveshare import STARTING_S, WaveshareBoard
from tests.drivers.serial.boards.waveshare.rig import RADIUS_M, Rig, rover
from tests.drivers.serial.boards.waveshare.test_protocol import OLDER
from tests.texts import Raises


def _metres(*feedback: tuple[int, float], every: float = 0.05) -> float:
    """Return the odometer's angle after repeated lines with these centimetres and speeds."""
    odometer = Odometer()
    for nth, (centimetres, speed) in enumerate(feedback):
        odometer.move(Track(centimetres, speed), nth * every)
    angle = odometer.angle(1.0)
    assert angle
    return angle.angle


def test_the_odometer_integrates_the_speed_within_a_centimetre() -> None:
    assert _metres((0, 0.06), (0, 0.06), (0, 0.06)) == pytest.approx(0.006)


@pytest.mark.parametrize(
    "centimetres, speed, metres",
    [(3, 0.0, 0.03), (-3, 0.0, -0.03), (0, 5.0, 0.01), (0, -5.0, -0.01), (3, 5.0, 0.04), (-3, -5.0, -0.04)],
)
def test_the_odometer_stays_within_the_centimetre(centimetres: int, speed: float, metres: float) -> None:
    assert _metres((0, 0.0), (centimetres, speed)) == pytest.approx(metres)


def test_no_error_adds_up() -> None:
    """The measured speed is twice too high, and the robot drives 10 m."""
    assert _metres(*((n, 0.4) for n in range(1001))) == pytest.approx(10.0, abs=0.01)


def test_a_wheel_that_stands_does_not_creep() -> None:
    assert _metres((0, 0.1), (0, 0.1), (0, 0.0), (0, 0.0), (0, 0.0)) == _metres((0, 0.1), (0, 0.1), (0, 0.0))


def test_the_odometer_continues_after_a_restart() -> None:
    odometer = Odometer()
    for nth, centimetres in enumerate((0, 20, -1, 700, 720)):
        if centimetres in (-1, 700):
            odometer.restart()
        odometer.move(Track(centimetres, 0.0), nth)
    angle = odometer.angle(1.0)
    assert angle
    assert angle.angle == pytest.approx(0.4, abs=0.011)


@pytest.mark.parametrize("centimetres, is_plausible", [(15, True), (-15, True), (1000, False), (-1000, False)])
def test_an_impossible_distance_is_not_plausible(centimetres: int, is_plausible: bool) -> None:
    odometer = Odometer()
    assert odometer.is_plausible(Track(1000, 0.0), 0.0)
    odometer.move(Track(0, 0.0), 0.0)
    assert odometer.is_plausible(Track(centimetres, 0.0), 0.05) is is_plausible


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    rig = Rig(tmp_path)
    yield rig
    with suppress(DeviceError):
        rig.close()


def test_the_time_out_is_set_before_the_board_turns(rig: Rig) -> None:
    rig.open(board_timeout_s=0.3).drive(4.0, 4.0)
    for before, line in pairwise(rig.board.received):
        assert line["T"] != 1 or before["T"] == 136
    assert rig.board.heartbeat_s == 0.3


def test_the_shortest_time_out_applies(rig: Rig) -> None:
    rig.open(board_timeout_s=5)
    rig.pass_time(0.01)
    assert rig.board.heartbeat_s == 0.5
    rig.drive(4.0, 4.0)
    assert rig.board.heartbeat_s == 5


def test_the_motors_of_a_tick_share_one_line_that_is_sent_once(rig: Rig) -> None:
    rig.open()
    rig.pass_time(0.01)
    rig.board.received.clear()
    rig.drive(5.0, -2.5)
    rig.pass_time(0.3)
    assert [line for line in rig.board.received if line["T"] == 1] == [{"T": 1, "L": 0.2, "R": -0.1}]


def test_the_board_stops_if_the_app_is_silent(rig: Rig) -> None:
    rig.open().drive(5.0, 5.0)
    assert rig.board.wheels.left.command == 5.0
    rig.pass_time(0.6)
    assert rig.board.wheels.left.command == 0.0


def test_a_lost_stop_is_repeated(rig: Rig) -> None:
    rig.open(board_timeout_s=5).drive(5.0, 5.0)
    rig.drive(0.0, 0.0)
    rig.board.wheels.set(5.0, 5.0)
    rig.pass_time(0.3)
    assert rig.board.wheels.left.command == 0.0


def test_angles_are_those_of_the_wheels(rig: Rig) -> None:
    rig.open().drive(5.0, -2.0, seconds=2)
    left, right = rig.angles()
    assert left == pytest.approx(rig.board.wheels.left.angle, abs=0.01 / RADIUS_M)
    assert right == pytest.approx(rig.board.wheels.right.angle, abs=0.01 / RADIUS_M)


def test_the_battery_is_reported_in_volts(rig: Rig) -> None:
    rig.board.centivolts = 1102
    assert rig.open().read_voltage() == 11.02


def test_a_board_that_echoes_is_understood(rig: Rig) -> None:
    rig.board.echoes = True
    rig.open().drive(5.0, 5.0)
    assert rig.board.wheels.left.command == 5.0


def test_the_greeting_switches_feedback_on(rig: Rig) -> None:
    rig.board.is_flowing = False
    rig.open()
    assert rig.angles() == (0.0, 0.0)


def test_the_greeting_switches_scaling_off(rig: Rig) -> None:
    rig.board.rates = (0.5, 0.5)
    rig.open().drive(5.0, 5.0)
    assert rig.board.wheels.left.command == 5.0


def test_a_command_during_a_silence_is_not_sent_after_it() -> None:
    protocol, feedback = WaveshareProtocol(115200), WaveshareBoard().feedback()
    for now in (0.0, 1.0):
        protocol.data_to_send(now)
        protocol.command.set("left", 0.2, now)
        protocol.receive(feedback, now)
        assert speeds(0.0, 0.0) in protocol.data_to_send(now)
        assert protocol.is_ready


def test_a_board_that_is_starting_is_waited_for(rig: Rig) -> None:
    rig.board.reset(0.0)
    rig.open()
    assert rig.clock.now() >= STARTING_S
    assert rig.board.heartbeat_s == 0.5


def test_a_board_that_is_reset_while_it_drives_stands_until_a_new_command(rig: Rig, raises: Raises) -> None:
    rig.open().drive(5.0, 5.0, seconds=1)
    angles = rig.angles()
    rig.board.reset(rig.clock.now())
    with raises(DeviceLostError, "board-silent", device="left_motor"):
        rig.drive(5.0, 5.0, seconds=SILENCE_S + 0.1)
    rig.pass_time(STARTING_S + 0.5)
    assert rig.board.wheels.left.angle == rig.board.wheels.right.angle == 0.0
    assert rig.board.heartbeat_s == 0.5
    assert rig.angles() == pytest.approx(angles, abs=0.1)
    rig.drive(5.0, 5.0, seconds=0.5)
    assert rig.angles()[0] > angles[0] + 1.0


def test_an_unplugged_port_is_lost_and_works_after_replugging(rig: Rig, raises: Raises) -> None:
    rig.open().drive(5.0, 5.0, seconds=0.5)
    rig.pty.unplug()
    with raises(DeviceLostError, "port-lost", device="left_motor"):
        rig.drive(5.0, 5.0, seconds=0.5)
    with raises(DeviceLostError, "port-lost", device="left_encoder"):
        rig.angles()
    with raises(DeviceLostError, "port-lost", device="battery"):
        rig.read_voltage()
    rig.pass_time(0.6)
    assert rig.board.wheels.left.command == 0.0, "its own time-out has stopped it"
    rig.pty.plug_in()
    rig.pass_time(3.0)
    assert rig.board.wheels.left.command == 0.0
    rig.drive(5.0, 5.0)
    assert rig.board.wheels.left.command == 5.0


def test_an_odometer_with_a_wrong_digit_is_no_angle(rig: Rig) -> None:
    rig.open().drive(5.0, 5.0, seconds=1)
    before = rig.angles()
    rig.pty.send_all(rig.board.feedback().replace(b'"odl":', b'"odl":9'))
    rig.pass_time(0.01)
    assert rig.angles() == pytest.approx(before, abs=0.1)


def test_noise_between_lines_changes_nothing(rig: Rig) -> None:
    rig.open().drive(5.0, 5.0, seconds=1)
    rig.pty.send_all(bytes(range(256)) + b"\n")
    rig.drive(5.0, 5.0, seconds=0.2)
    assert rig.angles()[0] == pytest.approx(rig.board.wheels.left.angle, abs=0.01 / RADIUS_M)


def test_a_board_with_the_older_firmware_is_refused(rig: Rig, monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.setattr(WaveshareDriver, "answer_s", 0.5)
    monkeypatch.setattr(WaveshareBoard, "feedback", lambda _board: OLDER)
    with raises(DeviceGroupError):
        rig.open()


def test_closing_stops_the_board(rig: Rig) -> None:
    rig.open(board_timeout_s=5).drive(5.0, 5.0)
    assert rig.robot
    rig.robot.close()
    rig.pass_time(0.01)
    assert rig.board.wheels.left.command == rig.board.wheels.right.command == 0.0


def test_another_process_stops_it_in_the_middle_of_a_line(rig: Rig) -> None:
    rig.open(board_timeout_s=5).drive(5.0, 5.0)
    assert rig.robot
    [cutoff] = (spec.make() for spec in merge_cutoffs(rig.robot.cutoffs))
    cutoff.open()
    rig.board.receive(speeds(0.3, 0.3)[:9], rig.clock.now())
    cutoff.stop()
    cutoff.close()
    rig.pass_time(0.01)
    assert rig.board.wheels.left.command == rig.board.wheels.right.command == 0.0


def test_a_motor_faster_than_the_board_obeys_is_refused(tmp_path: Path, raises: Raises) -> None:
    robot = rover(tmp_path / "board")
    fast = tuple(
        device.model_copy(update={"max_velocity_rad_s": 60.0}) if device.kind == "motor" else device
        for device in robot.devices
    )  # fmt: skip
    with raises(DescriptionError):
        SerialBackend().bindings(robot.model_copy(update={"devices": fast}))


def test_a_robot_without_a_drive_is_refused(tmp_path: Path, raises: Raises) -> None:
    robot = rover(tmp_path / "board").model_copy(update={"drive": None})
    with raises(DescriptionError):
        SerialBackend().bindings(robot)


SIDES = ("left", "right")


class TestWaveshare(SerialBench, ConformanceSuite):
    devices: ClassVar = {
        **{f"{side}_motor": {"driver": "waveshare-motor", "side": side, "board_timeout_s": 5} for side in SIDES},
        **{f"{side}_encoder": {"driver": "waveshare-encoder", "side": side} for side in SIDES},
        "battery": {"driver": "waveshare-battery"},
    }
    extra: ClassVar = (BatteryDescription(kind="battery", name="battery"),)

    def board(self) -> WaveshareBoard:
        return WaveshareBoard(2 * self.drive.wheel_radius_m)
