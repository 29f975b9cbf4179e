"""A Waveshare UGV board: its odometer, its greeting and its time-out."""

from __future__ import annotations

from itertools import pairwise

import pytest

from drivers.serial.boards.waveshare.drivers import WaveshareDriver
from drivers.serial.boards.waveshare.protocol import SILENCE_S, Odometer, TrackFeedback
from robotcore.errors import DeviceGroupError, DeviceLostError
from tests.doubles.serial.bench import Rig, board_devices
from tests.doubles.serial.waveshare import STARTING_S, WaveshareBoard
from tests.drivers.serial.boards.conftest import OpenRig
from tests.drivers.serial.boards.test_board import WHEEL_M
from tests.drivers.serial.boards.waveshare.test_protocol import OLDER
from tests.texts import Raises


def _metres(*feedback: tuple[int, float], every: float = 0.05) -> float:
    """Return the odometer's angle after repeated lines with these centimetres and speeds."""
    odometer = Odometer()
    for nth, (centimetres, speed) in enumerate(feedback):
        odometer.move(TrackFeedback(centimetres, speed), nth * every)
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


def test_the_odometer_continues_after_a_restart() -> None:
    odometer = Odometer()
    for nth, centimetres in enumerate((0, 20, -1, 700, 720)):
        if centimetres in (-1, 700):
            odometer.restart()
        odometer.move(TrackFeedback(centimetres, 0.0), nth)
    angle = odometer.angle(1.0)
    assert angle
    assert angle.angle == pytest.approx(0.4, abs=0.011)


@pytest.mark.parametrize("centimetres, is_plausible", [(15, True), (-15, True), (1000, False), (-1000, False)])
def test_an_impossible_distance_is_not_plausible(centimetres: int, is_plausible: bool) -> None:
    odometer = Odometer()
    assert odometer.is_plausible(TrackFeedback(1000, 0.0), 0.0)
    odometer.move(TrackFeedback(0, 0.0), 0.0)
    assert odometer.is_plausible(TrackFeedback(centimetres, 0.0), 0.05) is is_plausible


@pytest.fixture
def board() -> WaveshareBoard:
    return WaveshareBoard(WHEEL_M)


def open_rover(open_rig: OpenRig, board: WaveshareBoard, timeout_s: float = 5.0) -> Rig:
    rig = open_rig(board, board_devices("waveshare", {"board_timeout_s": timeout_s}, battery={}))
    assert rig.robot
    return rig


def test_the_time_out_is_set_before_the_board_turns(open_rig: OpenRig, board: WaveshareBoard) -> None:
    open_rover(open_rig, board, 0.3).drive(4.0, 4.0)
    for before, line in pairwise(board.received):
        assert line["T"] != 1 or before["T"] == 136
    assert board.heartbeat_s == 0.3


def test_a_trim_multiplies_the_velocity_that_the_board_gets(open_rig: OpenRig, board: WaveshareBoard) -> None:
    rig = open_rig(board, board_devices("waveshare", {"board_timeout_s": 5.0, "trim": 1.1}))
    rig.drive(5.0, -5.0)
    assert (board.wheels.left.command, board.wheels.right.command) == pytest.approx((5.5, -5.5), abs=0.01)


def test_a_lost_stop_is_repeated(open_rig: OpenRig, board: WaveshareBoard) -> None:
    rig = open_rover(open_rig, board)
    rig.drive(5.0, 5.0)
    rig.drive(0.0, 0.0)
    board.wheels.set(5.0, 5.0)
    rig.pass_time(0.3)
    assert board.wheels.left.command == 0.0


def test_the_greeting_switches_feedback_on_and_scaling_and_echoes_off(open_rig: OpenRig, board: WaveshareBoard) -> None:
    board.is_flowing, board.rates, board.echoes = False, (0.5, 0.5), True
    rig = open_rover(open_rig, board)
    assert rig.angle("left") == 0.0
    rig.drive(5.0, 5.0)
    assert board.wheels.left.command == pytest.approx(5.0, abs=0.01)
    assert not board.echoes


def test_a_board_that_is_starting_is_waited_for(open_rig: OpenRig, board: WaveshareBoard) -> None:
    board.reset(0.0)
    assert open_rover(open_rig, board).clock.now() >= STARTING_S
    assert board.heartbeat_s == 0.5


def test_a_board_that_is_reset_while_it_drives_stands_until_a_new_command(
    open_rig: OpenRig, board: WaveshareBoard, raises: Raises
) -> None:
    rig = open_rover(open_rig, board)
    rig.drive(5.0, 5.0, 1.0)
    before = rig.angle("left")
    board.reset(rig.clock.now())
    with raises(DeviceLostError, "board-silent", device="left_motor"):
        rig.drive(5.0, 5.0, SILENCE_S + 0.1)
    rig.pass_time(STARTING_S + 0.5)
    assert board.wheels.left.angle == board.wheels.right.angle == 0.0
    assert board.heartbeat_s == 5.0
    assert rig.angle("left") == pytest.approx(before, abs=0.1)
    rig.drive(5.0, 5.0, 0.5)
    assert rig.angle("left") > before + 1.0


def test_noise_and_a_wrong_digit_in_the_odometer_are_no_angle(open_rig: OpenRig, board: WaveshareBoard) -> None:
    rig = open_rover(open_rig, board)
    rig.drive(5.0, 5.0, 1.0)
    before = rig.angle("left")
    rig.pty.send_all(board.feedback().replace(b'"odl":', b'"odl":9') + bytes(range(256)) + b"\n")
    rig.pass_time(0.01)
    assert rig.angle("left") == pytest.approx(before, abs=0.1)
    rig.drive(5.0, 5.0, 0.2)
    assert rig.angle("left") == pytest.approx(board.wheels.left.angle, abs=0.02 / WHEEL_M)


def test_a_board_with_the_older_firmware_is_refused(
    open_rig: OpenRig, board: WaveshareBoard, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr(WaveshareDriver, "answer_s", 0.5)
    monkeypatch.setattr(WaveshareBoard, "feedback", lambda _board: OLDER)
    with raises(DeviceGroupError):
        open_rover(open_rig, board)
