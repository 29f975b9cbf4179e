"""In simulated time what goes over a line comes at the same times, though the kernel hands it over."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import pytest

from drivers.serial.backend import SECTION, SerialBackend
from robotcore.description import RobotDescription, load_robot
from robotcore.errors import DescriptionError, DeviceError, UsageError
from robotcore.hal.backend import Capability, Setup
from robotcore.hal.finding import Level
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.testing.simulation_rules import RepeatRules
from tests.doubles.serial.bench import SerialBench, wired
from tests.doubles.serial.board import Powered
from tests.doubles.serial.pty import Pty
from tests.doubles.serial.rosarduino import OurDouble
from tests.drivers.serial.boards.rosarduino.rig import WHEELS

MODEL = {"forward_rad_s": 16.0, "backward_rad_s": 16.0}
WHEELS_THAT_STAND = (
    "left_motor is there; right_motor is there; left_encoder reads 0.00 rad; right_encoder reads 0.00 rad. "
)


def motor(side: str, **settings: Any) -> dict[str, Any]:
    return {"driver": "sabertooth-motor", "motor": 1 if side == "left" else 2, "model": MODEL, **settings}


def robot_on(port: object, left: dict[str, Any], right: dict[str, Any]) -> RobotDescription:
    return wired(load_robot("rover"), {"left_motor": left, "right_motor": right}, Path(str(port)))


@pytest.fixture
def pty(tmp_path: Path) -> Iterator[Pty]:
    with Pty(tmp_path) as pty:
        yield pty


@pytest.fixture
def robot(pty: Pty) -> RobotDescription:
    return robot_on(pty.path, motor("left"), motor("right"))


def setup_of(robot: RobotDescription, **options: str) -> Setup:
    return Setup(robot, None, frozenset(device.name for device in robot.devices), options=options)


def faults_of(robot: RobotDescription) -> str:
    with pytest.raises(DescriptionError) as caught:
        SerialBackend().check(robot)
    return str(caught.value)


def test_a_robot_is_reported_by_its_devices_and_ports(robot: RobotDescription, pty: Pty) -> None:
    assert SerialBackend().check(robot) == f"2 devices on {pty.path}"


def test_the_option_port_takes_the_place_of_the_robots_one_port(pty: Pty) -> None:
    robot = robot_on("/dev/nowhere", motor("left"), motor("right"))
    with pytest.raises(DeviceError, match="there is no /dev/nowhere"):
        SerialBackend().open(setup_of(robot))
    with SerialBackend().open(setup_of(robot, port=str(pty.path))) as opened:
        assert set(opened.devices) == {"left_motor", "right_motor"}


def test_a_port_that_cannot_be_opened_is_reported_once_and_not_tried_for_each_device() -> None:
    robot = robot_on("/dev/nowhere", motor("left"), motor("right"))
    with pytest.raises(DeviceError) as caught:
        SerialBackend().open(setup_of(robot))
    assert str(caught.value).count("there is no /dev/nowhere") == 1
    assert "right_motor: is on /dev/nowhere too, which could not be opened for left_motor" in str(caught.value)


def test_the_option_port_is_refused_where_the_robot_has_two_ports() -> None:
    robot = robot_on("/dev/a", motor("left"), motor("right", port="/dev/b"))
    with pytest.raises(UsageError, match=r"has 2 ports, /dev/a, /dev/b. Leave it out, and name them in \[serial\]"):
        SerialBackend().open(setup_of(robot, port="/dev/c"))


def test_an_option_port_that_is_no_place_is_refused(robot: RobotDescription) -> None:
    with pytest.raises(UsageError, match=r"option port: .*usb:1a86.* is no USB id"):
        SerialBackend().open(setup_of(robot, port="usb:1a86"))


def test_two_devices_on_one_side_are_refused() -> None:
    faults = faults_of(robot_on("/dev/a", motor("left"), motor("left")))
    assert "is already serial.left_motor." in faults


def test_two_speeds_on_one_port_are_refused() -> None:
    faults = faults_of(robot_on("/dev/a", motor("left"), motor("right", baud=38400)))
    assert "serial.right_motor.port: serial /dev/a is already serial.left_motor.port, where " in faults
    assert "at 9600 baud is spoken. Connect one of them elsewhere, or write the same baud at all that is on" in faults


def test_two_languages_on_one_port_are_refused() -> None:
    faults = faults_of(robot_on("/dev/a", motor("left"), {"driver": "waveshare-motor", "side": "right", "baud": 9600}))
    assert "serial.right_motor.port: serial /dev/a is already serial.left_motor.port, where Sabertooth" in faults


def test_a_port_that_is_no_usb_id_is_refused() -> None:
    faults = faults_of(robot_on("usb:xyz", motor("left"), motor("right")))
    assert "serial.left_motor.port: 'usb:xyz' is no USB id. Write usb:VENDOR:PRODUCT" in faults


def test_wires_are_sent_without_a_connector(robot: RobotDescription, pty: Pty) -> None:
    wiring = SerialBackend().wiring(robot)
    assert not wiring.pads
    assert [wire.where for wire in wiring.wires if wire.signal == "port"] == [f"serial {pty.path}"] * 2


class TestDoctor:
    def found(self, robot: RobotDescription | None) -> list[tuple[str, Level, str]]:
        return [(each.what, each.level, f"{each.said}. {each.remedy}") for each in SerialBackend().examine(robot)]

    def test_boards_that_never_answer_are_not_said_to_be_there(self, robot: RobotDescription, pty: Pty) -> None:
        *_, port, boards = self.found(robot)
        assert port == ("port", Level.OK, f"{pty.path} opens at 9600 baud. ")
        assert boards[:2] == ("boards", Level.WARNING)
        assert boards[2].startswith("could not be checked: left_motor and right_motor: what they are on never answers")

    def test_boards_that_answer_are_opened_and_read(self, pty: Pty) -> None:
        clock = MonotonicClock()
        powered = Powered(OurDouble(), pty, clock)
        *_, boards = self.found(wired(load_robot("rover"), WHEELS, pty.path))
        powered.off()
        clock.close()
        assert boards == ("boards", Level.OK, WHEELS_THAT_STAND)

    def test_a_port_that_is_not_there_is_an_error_and_nothing_is_opened(self) -> None:
        *_, last = self.found(robot_on("/dev/nowhere", motor("left"), motor("right")))
        assert last[:2] == ("port", Level.ERROR)
        assert "there is no /dev/nowhere" in last[2]
        assert ". Plug the board in" in last[2]

    @pytest.mark.parametrize(
        "said, fault",
        [(b"", "nothing on {} answers"), (b"Hello!", "something speaks on {}, but not what this driver's board does")],
    )
    def test_a_board_that_does_not_answer_is_one_error_however_many_devices_are_on_it(
        self, pty: Pty, monkeypatch: pytest.MonkeyPatch, said: bytes, fault: str
    ) -> None:
        monkeypatch.setattr("drivers.serial.boards.rosarduino.drivers.ANSWER_S", 0.3)
        clock = MonotonicClock()
        talking = clock.every(0.02, lambda: pty.say(said), "talking")
        *_, port, board = self.found(wired(load_robot("rover"), WHEELS, pty.path))
        talking.stop()
        clock.close()
        assert port[:2] == ("port", Level.OK)
        assert board[:2] == ("boards", Level.ERROR)
        assert board[2].startswith(f"left_encoder: {fault.format(pty.path)} at 57600 baud. Look whether")

    def test_a_camera_is_looked_at_too(self) -> None:
        robot = wired(load_robot("rover"), {"eye": {"driver": "v4l2", "device": "/dev/video99"}}, Path("/dev/nowhere"))
        del robot.backends[SECTION]["eye"]["port"]
        *_, camera = self.found(robot)
        assert camera[:2] == ("camera", Level.ERROR)
        assert camera[2].startswith("eye: there is no /dev/video99")

    def test_a_port_that_another_program_reads_is_reported_and_its_board_is_looked_at(self, pty: Pty) -> None:
        clock = MonotonicClock()
        powered = Powered(OurDouble(), pty, clock)
        with pty.path.open() as port, subprocess.Popen(["/bin/sleep", "60"], stdin=port) as reader:
            robot = wired(load_robot("rover"), WHEELS, pty.path)
            *_, found, boards = self.found(robot)
            (note,) = SerialBackend().notes(setup_of(robot))
            reader.kill()
        powered.off()
        clock.close()
        said = f"{pty.path} is open in process {reader.pid} (sleep) too, and each gets a part of what the board says"
        assert found == ("port", Level.WARNING, f"{said}. End that program")
        assert note == f"{said}. End that program"
        assert boards == ("boards", Level.OK, WHEELS_THAT_STAND)

    def test_a_section_that_is_wrong_is_an_error(self) -> None:
        *_, last = self.found(robot_on("/dev/a", motor("left"), motor("left")))
        assert last[:2] == ("robot", Level.ERROR)

    def test_a_robot_on_no_serial_line_is_reported_so(self) -> None:
        *_, last = self.found(load_robot("lookout"))
        assert last[:2] == ("robot", Level.WARNING)
        assert f"has no [{SECTION}]" in last[2]

    def test_without_a_robot_the_ports_are_sent(self) -> None:
        assert [what for what, _, _ in self.found(None)] == ["ports", "robot"]


WHEEL_SIDES = ("left", "right")


class SimulatedTask(SerialBackend):
    capabilities = frozenset({Capability.LOCKSTEP})


class TestTwoRuns(SerialBench, RepeatRules):
    backend = SimulatedTask
    devices: ClassVar = {
        **{f"{side}_motor": {"driver": "ros-arduino-motor", "side": side} for side in WHEEL_SIDES},
        **{f"{side}_encoder": {"driver": "ros-arduino-encoder", "side": side} for side in WHEEL_SIDES},
    }

    def board(self) -> OurDouble:
        return OurDouble(counts_per_turn=3840)
