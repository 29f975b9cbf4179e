"""The backend `serial`: its options, its checks, its doctor, and two runs that are equal in simulated time."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import pytest

from drivers.serial.backend import SECTION, SerialBackend
from drivers.serial.port import describe_ports
from robotcore.description import RobotDescription, load_robot
from robotcore.errors import DescriptionError, DeviceError, DeviceGroupError, UsageError
from robotcore.hal.backend import Capability, Setup
from robotcore.hal.check_finding import Finding, Level
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.bumper import BumperDescription
from robotcore.kinds.encoder import EncoderDescription
from robotcore.testing.simulation_rules import RepeatRules
from tests.doubles.serial.bench import SerialBench, board_devices, connect_devices
from tests.doubles.serial.board import Powered
from tests.doubles.serial.pty import Pty
from tests.doubles.serial.rosarduino import RobotcoreBridgeDouble
from tests.texts import CheckText, Raises

MODEL = {"forward_rad_s": 16.0, "backward_rad_s": 16.0}


def motor(side: str, **settings: Any) -> dict[str, Any]:
    return {"driver": "sabertooth-motor", "motor": 1 if side == "left" else 2, "model": MODEL, **settings}


def robot_on(port: object, left: dict[str, Any], right: dict[str, Any]) -> RobotDescription:
    return connect_devices({"left_motor": left, "right_motor": right}, port)


@pytest.fixture
def pty(tmp_path: Path) -> Iterator[Pty]:
    with Pty(tmp_path) as pty:
        yield pty


@pytest.fixture
def robot(pty: Pty) -> RobotDescription:
    return robot_on(pty.path, motor("left"), motor("right"))


def setup_of(robot: RobotDescription, **options: str) -> Setup:
    return Setup(robot, None, frozenset(device.name for device in robot.devices), options=options)


def test_a_robot_is_reported_by_its_devices_and_ports(robot: RobotDescription, pty: Pty) -> None:
    assert SerialBackend().check(robot) == f"2 devices on {pty.path}"


def test_missing_table_suggests_only_drivers_of_the_backend(robot: RobotDescription, raises: Raises) -> None:
    front = BumperDescription(kind="bumper", name="front")
    encoder = EncoderDescription(kind="encoder", name="caster", counts_per_turn=20)
    equipped = robot.model_copy(update={"devices": (*robot.devices, front, encoder)})
    with raises(DescriptionError, "missing-section"):
        SerialBackend().check(equipped)


@pytest.mark.slow
def test_the_option_port_replaces_the_robots_only_port(pty: Pty) -> None:
    robot = robot_on("/dev/nowhere", motor("left"), motor("right"))
    with pytest.raises(DeviceError):
        SerialBackend().open(setup_of(robot))
    with SerialBackend().open(setup_of(robot, port=str(pty.path))) as opened:
        assert set(opened.devices) == {"left_motor", "right_motor"}


def test_a_port_that_cannot_be_opened_is_reported_once_and_not_tried_for_each_device(raises: Raises) -> None:
    robot = robot_on("/dev/nowhere", motor("left"), motor("right"))
    with raises(DeviceGroupError, hide=[describe_ports()]) as caught:
        SerialBackend().open(setup_of(robot))
    kinds = [failure.kind for failure in caught.value.failures if isinstance(failure, DeviceError)]
    assert kinds == ["port-not-opened", "shared-board"]


def test_the_option_port_is_refused_if_the_robot_has_two_ports(raises: Raises) -> None:
    robot = robot_on("/dev/a", motor("left"), motor("right", port="/dev/b"))
    with raises(UsageError, "port-ambiguous", ports=["/dev/a", "/dev/b"]):
        SerialBackend().open(setup_of(robot, port="/dev/c"))


def test_an_option_port_with_an_incomplete_usb_id_is_refused(robot: RobotDescription, raises: Raises) -> None:
    with raises(UsageError, "invalid-option", option="port"):
        SerialBackend().open(setup_of(robot, port="usb:1a86"))


@pytest.mark.parametrize("port", ["ttyUSB0", "COM"])
def test_a_port_that_is_no_path_is_refused(port: str, raises: Raises) -> None:
    with raises(DescriptionError, "invalid-value"):
        SerialBackend().check(robot_on(port, motor("left"), {**motor("right")}))


@pytest.mark.parametrize(
    "right",
    [motor("right", baud=38400), {"driver": "waveshare-motor", "side": "right", "baud": 9600}],
    ids=["two-speeds", "two-protocols"],
)
def test_devices_that_cannot_share_a_port_are_refused(right: dict[str, Any], raises: Raises) -> None:
    with raises(DescriptionError, "pin-conflict"):
        SerialBackend().check(robot_on("/dev/a", motor("left"), right))


@pytest.mark.parametrize("device", ["nose", "eye"])
def test_a_driver_for_a_connector_of_the_pi_is_refused(device: str, raises: Raises) -> None:
    rover = load_robot("rover")
    tables = {**rover.backends[SECTION], device: rover.backends["raspberrypi"][device]}
    robot = rover.model_copy(update={"backends": {SECTION: tables}})
    with raises(DescriptionError, "unknown-pin"):
        SerialBackend().check(robot)


def test_wires_have_no_connector(robot: RobotDescription, pty: Pty) -> None:
    wiring = SerialBackend().wiring(robot)
    assert not wiring.pads
    assert [wire.where for wire in wiring.wires if wire.signal == "port"] == [f"serial {pty.path}"] * 2


class TestDoctor:
    def examine(self, robot: RobotDescription | None) -> list[Finding]:
        return list(SerialBackend().examine(robot))

    def test_boards_that_never_answer_are_unchecked(self, robot: RobotDescription, check_text: CheckText) -> None:
        *_, port, boards = self.examine(robot)
        assert (port.subject, port.level, port.kind) == ("port", Level.OK, "port-ok")
        assert (boards.subject, boards.level, boards.kind) == ("boards", Level.WARNING, "board-mute")
        check_text(port)
        check_text(boards)

    def test_boards_that_answer_are_opened_and_read(self, pty: Pty, check_text: CheckText) -> None:
        clock = MonotonicClock()
        powered = Powered(RobotcoreBridgeDouble(), pty, clock)
        *_, boards = self.examine(connect_devices(board_devices("ros-arduino"), pty.path))
        powered.off()
        clock.close()
        assert (boards.subject, boards.level, boards.kind) == ("boards", Level.OK, "boards-ok")
        check_text(boards)

    def test_a_missing_port_is_an_error_and_nothing_is_opened(self, check_text: CheckText) -> None:
        *_, last = self.examine(robot_on("/dev/nowhere", motor("left"), motor("right")))
        assert (last.subject, last.level, last.kind) == ("port", Level.ERROR, "port-not-opened")
        check_text(last, hide=[describe_ports()])

    @pytest.mark.parametrize("said", [b"", b"Hello!"], ids=["silence", "another-protocol"])
    def test_a_silent_board_is_one_error_for_all_of_its_devices(
        self, pty: Pty, monkeypatch: pytest.MonkeyPatch, said: bytes, check_text: CheckText
    ) -> None:
        monkeypatch.setattr("drivers.serial.boards.rosarduino.drivers.ArduinoDriver.answer_s", 0.3)
        clock = MonotonicClock()
        talking = clock.call_every(0.02, lambda: pty.send(said), "talking")
        *_, port, board = self.examine(connect_devices(board_devices("ros-arduino"), pty.path))
        talking.stop()
        clock.close()
        assert (port.subject, port.level) == ("port", Level.OK)
        assert (board.subject, board.level, board.kind) == ("boards", Level.ERROR, "board-silent")
        check_text(board)

    def test_a_camera_is_examined_too(self) -> None:
        robot = connect_devices({"eye": {"driver": "v4l2", "device": "/dev/video99"}})
        del robot.backends[SECTION]["eye"]["port"]
        *_, camera = self.examine(robot)
        assert (camera.subject, camera.level) == ("camera", Level.ERROR)
        assert "/dev/video99" in camera.message

    def test_a_port_that_another_program_reads_is_reported_and_its_board_is_read(
        self, pty: Pty, check_text: CheckText
    ) -> None:
        clock = MonotonicClock()
        powered = Powered(RobotcoreBridgeDouble(), pty, clock)
        with pty.path.open() as file, subprocess.Popen(["/bin/sleep", "60"], stdin=file) as reader:
            robot = connect_devices(board_devices("ros-arduino"), pty.path)
            *_, port, boards = self.examine(robot)
            (note,) = SerialBackend().notes(setup_of(robot))
            reader.kill()
        powered.off()
        clock.close()
        assert (port.subject, port.level, port.kind) == ("port", Level.WARNING, "port-shared")
        assert (boards.subject, boards.level) == ("boards", Level.OK)
        check_text(port, hide=[reader.pid])
        check_text(note, hide=[reader.pid])

    def test_a_mistake_in_the_section_is_an_error(self) -> None:
        *_, last = self.examine(robot_on("/dev/a", motor("left"), motor("left")))
        assert (last.subject, last.level, last.kind) == ("robot", Level.ERROR, "pin-conflict")

    def test_a_robot_without_a_section_is_a_warning(self, check_text: CheckText) -> None:
        *_, last = self.examine(load_robot("lookout"))
        assert (last.subject, last.level, last.kind) == ("robot", Level.WARNING, "no-section")
        check_text(last)

    def test_the_ports_are_listed_without_a_robot(self) -> None:
        assert [finding.kind for finding in self.examine(None)] == ["ports", "no-robot"]


class SimulatedTask(SerialBackend):
    capabilities = frozenset({Capability.LOCKSTEP})


class TestTwoRuns(SerialBench, RepeatRules):
    backend = SimulatedTask
    devices: ClassVar = board_devices("ros-arduino")

    def board(self) -> RobotcoreBridgeDouble:
        return RobotcoreBridgeDouble(counts_per_turn=3840)
