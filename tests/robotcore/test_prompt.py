"""The values that a user holds at a prompt show themselves as one short line, and some as a picture in a notebook."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, cast

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import robotcore
from robotcore import Navigator, OccupancyGrid, Pose, Twist
from robotcore.autonomy.navigation.grid_picture import UNKNOWN
from robotcore.autonomy.vision import Blob
from robotcore.canvas import BAD, INK, PAPER
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
from robotcore.kinds.servo import ServoDescription
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
    (Scan((math.nan, 2.0, 0.5), 3.15, 63), "Scan nearest 0.50 m, 2 of 3 rays with an echo at 3.15 s"),
    (Scan((), 3.15, 63), "Scan 0 of 0 rays with an echo at 3.15 s"),
    (Scan((math.inf,) * 3, 3.15, 63), "Scan 0 of 3 rays with an echo at 3.15 s"),
    (
        GamepadSample(**{**AT_REST, "left_y": 0.5, "south": True}, time=3.15, sequence=63),
        "GamepadSample left_y 0.50, south at 3.15 s",
    ),
    (Frame(np.zeros((240, 320, 3), np.uint8), 3.15, 63), "<Frame 320x240 at 3.15 s>"),
    (Twist(0.1 + 0.2, -0.0), "Twist(linear=0.3 m/s, angular=0 rad/s)"),
    (Pose(1.0, 12.34567, math.pi), "Pose(x=1 m, y=12.3457 m, heading=3.1416 rad)"),
    (
        Pose(cast("Any", None), cast("Any", "left"), cast("Any", (1, 2))),
        "Pose(x=None m, y='left' m, heading=(1, 2) rad)",
    ),
    (Twist(cast("Any", np.zeros(2)), 0.5), "Twist(linear=array([0., 0.]) m/s, angular=0.5 rad/s)"),
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


def test_sample_formats_its_values_without_its_class_and_time() -> None:
    assert Range(1.239, 3.15, 63).format_values() == "1.24 m"


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

        def format_values(self) -> str:
            return "a tone"

    @dataclass(frozen=True, repr=False)
    class Chord(Note):
        def __repr__(self) -> str:
            return "<Chord>"

    build_kind(Note)
    build_kind(Chord)
    assert [repr(Note(440.0, 1.0, 0)), repr(Chord(440.0, 1.0, 0))] == ["Note a tone at 1.00 s", "<Chord>"]


def test_clock_shows_its_time() -> None:
    mock = MockRobot(range=[0.84])
    mock.advance(3)
    assert repr(mock.layered.clock) == "<AppClock at 0.15 s>"


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


def decode(png: bytes) -> NDArray[Any]:
    image = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    return image


class TestNotebookPictures:
    def test_frame_shows_its_own_pixels(self) -> None:
        image = np.arange(4 * 6 * 3, dtype=np.uint8).reshape(4, 6, 3)
        np.testing.assert_array_equal(decode(Frame(image, 0.0, 0)._repr_png_()), image)

    def test_grey_frame_shows_its_own_pixels(self) -> None:
        image = np.arange(24, dtype=np.uint8).reshape(4, 6)
        np.testing.assert_array_equal(decode(Frame(image, 0.0, 0)._repr_png_())[..., 0], image)

    def test_chart_of_a_scan_has_high_columns_for_far_rays_from_left_to_right(self) -> None:
        chart = decode(Scan((4.0,) * 50 + (1.0,) * 50, 0.0, 0)._repr_png_())  # the first ray is the rightmost
        heights = (chart[30:, :, 2] < 100).sum(axis=0)
        assert heights[400] > 3 * heights[100] > 50

    def test_chart_of_a_scan_leaves_rays_without_an_echo_empty(self) -> None:
        chart = decode(Scan((1.0, math.inf, math.inf), 0.0, 0)._repr_png_())
        assert (chart[100, [50, 200, 450], 2] < 100).tolist() == [False, False, True]

    @pytest.mark.parametrize("distances", [(math.inf,) * 4, (math.nan,), ()], ids=["inf", "nan", "no rays"])
    def test_scan_without_an_echo_has_a_chart(self, distances: tuple[float, ...]) -> None:
        assert decode(Scan(distances, 0.0, 0)._repr_png_()).shape == (160, 480, 3)

    def test_map_shows_free_occupied_and_unknown_cells_with_y_upward(self) -> None:
        grid = OccupancyGrid(size=4.0, cell=0.04)
        grid.evidence[:] = np.where(np.arange(100)[:, None] >= 50, 1.0, -1.0)  # occupied above the middle
        grid.evidence[:, :50] = 0.0
        picture = decode(grid._repr_png_())
        height, width = picture.shape[:2]
        right = width * 3 // 4
        assert picture[height // 4, right].tolist() == list(INK[::-1])
        assert picture[height * 3 // 4, right].tolist() == list(PAPER[::-1])
        assert picture[height // 2, 2].tolist() == list(UNKNOWN[::-1])

    def test_map_without_known_cells_has_a_picture(self) -> None:
        assert set(decode(OccupancyGrid()._repr_png_()).ravel()) == set(UNKNOWN)

    def test_map_shows_the_robot_and_a_path(self) -> None:
        grid = OccupancyGrid()
        plain, path = grid.draw(), grid.draw(path=[(0.0, 0.0), (0.5, 0.5)])
        robot = grid.draw(Pose(0.0, 0.0, 1.0))
        assert all((picture != UNKNOWN[::-1]).any() for picture in (path, robot))
        assert not (plain != UNKNOWN[::-1]).any()

    def test_map_grows_to_a_robot_beyond_the_known_cells(self) -> None:
        grid = OccupancyGrid()
        grid.add_free_disc(-4.0, -4.0, 0.2, 0.2)
        assert (grid.draw(Pose(4.0, 4.0, 0.0)) == BAD[::-1]).all(axis=2).any()

    def test_navigator_shows_its_map_pose_and_path(self) -> None:
        navigator = Navigator(speed=0.2, turn=1.0)
        assert repr(navigator) == "<Navigator: map of 0 free and 0 occupied cells, path of 0 cells>"
        robot = MockRobot(range=[math.inf]).layered
        navigator.observe(robot, Pose(0.0, 0.0, 0.0))
        assert (decode(navigator._repr_png_()) == BAD[::-1]).all(axis=2).any()


class TestCompletion:
    def test_package_completes_each_of_its_names(self) -> None:
        assert dir(robotcore) == robotcore.__all__
        for name in dir(robotcore):
            assert getattr(robotcore, name) is not None

    def test_robot_completes_its_devices_in_brackets(self) -> None:
        robot = MockRobot().layered
        assert robot._ipython_key_completions_() == list(robot.devices)

    def test_device_completes_the_attributes_of_its_driver(self) -> None:
        limits: dict[str, Any] = {"min_angle_rad": -1.0, "max_angle_rad": 1.0, "max_velocity_rad_s": 5.0}
        pan = ServoDescription(kind="servo", name="pan", **limits)
        rover = load_robot("rover")
        robot = MockRobot(rover.model_copy(update={"devices": (*rover.devices, pan)})).layered
        assert {"set_angle", "min_angle", "max_angle", "angle"} <= set(dir(robot["pan"]))
        assert {"read", "intrinsics", "mount"} <= set(dir(robot.camera))
        for name in dir(robot["pan"]):
            getattr(robot["pan"], name)
