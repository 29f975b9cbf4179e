"""The values that a user holds at a prompt show themselves as one short line."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import pytest

from robotcore import Pose, Twist
from robotcore.autonomy.vision import Blob
from robotcore.description import load_robot, load_world
from robotcore.geometry import Wheels
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.kind import Kind
from robotcore.kinds.battery import Voltage
from robotcore.kinds.bumper import Touch
from robotcore.kinds.camera import Frame
from robotcore.kinds.encoder import Angle
from robotcore.kinds.gamepad import AXES, BUTTONS, TRIGGERS, GamepadSample
from robotcore.kinds.imu import ImuDescription, ImuSample
from robotcore.kinds.led import LedDescription
from robotcore.kinds.lidar import Scan
from robotcore.kinds.line_sensor import Darkness
from robotcore.kinds.range_sensor import Range
from robotcore.testing import MockRobot

AT_REST: dict[str, Any] = {**dict.fromkeys((*AXES, *TRIGGERS), 0.0), **dict.fromkeys(BUTTONS, False)}
LINES: list[tuple[object, str]] = [
    (Range(1.239, 3.15, 63), "Range 1.24 m at 3.15 s"),
    (Range(math.inf, 3.15, 63), "Range nothing in range at 3.15 s"),
    (Range(math.nan, 3.15, 63), "Range nan m at 3.15 s"),
    (Voltage(float(np.float32(7.4)), 3.15, 63), "Voltage 7.40 V at 3.15 s"),
    (Angle(-0.001, 3.15, 63), "Angle 0.00 rad at 3.15 s"),
    (Touch(True, 3.15, 63), "Touch pressed at 3.15 s"),
    (Touch(False, 3.15, 63), "Touch not pressed at 3.15 s"),
    (Darkness((1.0, 0.25), 3.15, 63), "Darkness 1.00 0.25 at 3.15 s"),
    (Darkness((0.0,) * 9 + (1.0,), 3.15, 63), "Darkness 10 values from 0.00 to 1.00 at 3.15 s"),
    (
        ImuSample(0.1, 0.0, -0.25, 1.5, 3.15, 63),
        (
            "ImuSample yaw rate 0.10 rad/s, forward acceleration 0.00 m/s², left acceleration -0.25 m/s², "
            "heading 1.50 rad at 3.15 s"
        ),
    ),
    (Scan((math.inf, 2.0, 0.5), 3.15, 63), "Scan nearest 0.50 m, 2 of 3 rays with an echo at 3.15 s"),
    (Scan((math.inf,) * 3, 3.15, 63), "Scan 0 of 3 rays with an echo at 3.15 s"),
    (
        GamepadSample(**{**AT_REST, "left_y": 0.5, "south": True}, time=3.15, sequence=63),
        "GamepadSample left_y 0.50, south at 3.15 s",
    ),
    (Frame(np.zeros((240, 320, 3), np.uint8), 3.15, 63), "<Frame 320x240 at 3.15 s>"),
    (Twist(0.1 + 0.2, -0.0), "Twist(linear=0.3 m/s, angular=0 rad/s)"),
    (Pose(1.0, 12.34567, math.pi), "Pose(x=1 m, y=12.3457 m, heading=3.1416 rad)"),
    (Wheels(10.0, -2.5), "Wheels(left=10, right=-2.5)"),
    (
        Blob((20.0, 15.0), (0, 12, 5, 7), 35, 0.1, is_clipped=True),
        "<Blob of 35 pixels at (20, 15), bearing 0.10 rad, clipped>",
    ),
    (load_world("arena"), "<WorldDescription arena: 4 x 4 m, 6 obstacles, 1 target>"),
    (load_world("track"), "<WorldDescription track: 3 x 2.2 m, 1 line>"),
    (
        load_robot("rover"),
        "<RobotDescription rover: differential drive, 2 motors, 2 encoders, 1 range sensor, 1 camera, 1 display>",
    ),
]


@pytest.mark.parametrize("value, line", LINES, ids=lambda each: each if isinstance(each, str) else "")
def test_value_shows_itself_as_one_line_with_units(value: object, line: str) -> None:
    assert repr(value) == line


def test_range_sample_prints_its_distance() -> None:
    assert str(Range(1.239, 3.15, 63)) == "1.24 m"


def build_kind(sample: type) -> Kind:
    sensor = type("Foreign", (Sensor,), {"kind": "imu"})
    return Kind("a foreign sensor", ImuDescription, sensor, sample)


def test_sample_of_a_foreign_kind_shows_its_values_with_their_units() -> None:
    @dataclass(frozen=True)
    class Gas:
        label: str
        co2: Annotated[float, Unit("ppm")]
        is_hot: Annotated[bool, Unit("")]
        time: float
        sequence: int

    build_kind(Gas)
    assert repr(Gas("red\n", 400.0, True, 1.0, 0)) == r"Gas label 'red\n', co2 400.00 ppm, hot at 1.00 s"


def test_sample_of_a_foreign_kind_keeps_its_own_texts() -> None:
    @dataclass(frozen=True)
    class Note:
        pitch: Annotated[float, Unit("Hz")]
        time: float
        sequence: int

        def __str__(self) -> str:
            return "a tone"

    @dataclass(frozen=True, repr=False)
    class Chord(Note):
        def __repr__(self) -> str:
            return "<Chord>"

    build_kind(Note)
    build_kind(Chord)
    assert [repr(Note(440.0, 1.0, 0)), repr(Chord(440.0, 1.0, 0))] == ["Note a tone at 1.00 s", "<Chord>"]


class TestDevices:
    def test_sensor_shows_its_last_sample_and_reads_no_hardware(self) -> None:
        mock = MockRobot(range=[0.84, 0.5])
        nose = mock.layered.range
        assert repr(nose) == "<RangeSensor nose>"
        nose.read()
        mock.advance()
        assert repr(nose) == "<RangeSensor nose: 0.84 m at 0.00 s>"

    def test_camera_shows_the_size_of_its_last_frame(self) -> None:
        camera = MockRobot().layered.camera
        camera.read()
        assert repr(camera) == "<Camera eye: 320x240 pixels at 0.00 s>"

    def test_actuator_shows_the_command_that_was_sent(self) -> None:
        lamp = LedDescription(kind="led", name="lamp")
        rover = load_robot("rover")
        robot: Any = MockRobot(rover.model_copy(update={"devices": (*rover.devices, lamp)})).layered
        robot["lamp"].set_brightness(9.0)
        assert repr(robot["lamp"]) == "<Led lamp: 1.00 1.00 1.00>"

    def test_display_shows_no_picture_as_a_text(self) -> None:
        display = MockRobot().layered.display
        display.show(np.zeros((2, 2, 3), np.uint8))
        assert repr(display) == "<Display screen>"

    def test_closed_device_says_so(self) -> None:
        robot = MockRobot(range=[0.84]).layered
        robot.range.read()
        robot.close()
        assert [repr(robot["nose"]), repr(robot["left_motor"])] == [
            "<RangeSensor nose: closed>",
            "<Motor left_motor: closed>",
        ]
