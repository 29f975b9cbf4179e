from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from robotcore import OccupancyGrid, Pose
from robotcore.canvas import BAD, INK, SERIES, Canvas, Point
from robotcore.description import WorldDescription, load_robot, load_world
from robotcore.errors import UsageError
from robotcore.kinds.led import LedDescription
from robotcore.optics import Image
from robotcore.testing import MockRobot
from robotcore.view.page import EDGE, MAP, SIDE, SIDE_WIDTH, TOP
from robotcore.view.robot_picture import _list_readings, draw_robot
from tests.texts import Raises

PATH = [Pose(0.01 * step, 0.0, 0.0) for step in range(60)]


@pytest.fixture
def mock() -> MockRobot:
    rover = load_robot("rover")
    lamp = LedDescription(kind="led", name="lamp")
    return MockRobot(rover.model_copy(update={"devices": (*rover.devices, lamp)}), range=[0.84, 0.5])


def crop_map(image: Image) -> Image:
    return image[TOP : TOP + MAP, EDGE : EDGE + MAP]


def count_colour(image: Image, colour: tuple[int, int, int]) -> int:
    return int((image == colour[::-1]).all(axis=2).sum())


def test_picture_shows_the_last_picture_of_the_camera(mock: MockRobot) -> None:
    mock.layered.camera.read()
    image = draw_robot(mock.layered, mock.description).image
    assert image[TOP + 100, SIDE + SIDE_WIDTH // 2].tolist() == [128, 128, 128]


def test_readings_are_the_last_samples_and_commands(mock: MockRobot) -> None:
    assert list(_list_readings(mock.layered)) == []
    mock.layered.range.read()
    lamp: Any = mock.layered["lamp"]
    lamp.set_brightness(0.5)
    mock.advance(20)
    assert list(_list_readings(mock.layered)) == [("nose", "0.84 m", "0.00 s"), ("lamp", "0.50 0.50 0.50", "")]


def test_command_beyond_the_limits_is_shown_as_it_was_sent(mock: MockRobot) -> None:
    lamp: Any = mock.layered["lamp"]
    lamp.set_brightness(9.0)
    assert list(_list_readings(mock.layered)) == [("lamp", "1.00 1.00 1.00", "")]


@pytest.mark.parametrize("world, source", [(load_world("arena"), "true pose"), (None, "odometry")])
def test_pose_is_that_of_the_world_or_of_the_odometry(
    mock: MockRobot, world: WorldDescription | None, source: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts: list[str] = []
    write_text = Canvas.write_text

    def write(canvas: Canvas, at: Point, text: str, *how: Any, **options: Any) -> float:
        texts.append(text)
        return write_text(canvas, at, text, *how, **options)

    monkeypatch.setattr(Canvas, "write_text", write)
    draw_robot(mock.layered, mock.description, PATH, world=world)
    assert f"{source}: x 0.59 m, y 0.00 m, heading 0.00 rad" in texts


def test_drawing_reads_no_device(mock: MockRobot) -> None:
    draw_robot(mock.layered, mock.description, PATH)
    assert mock.layered.range.read().distance == 0.84  # the first reading of the script


@pytest.mark.slow
def test_path_is_drawn_in_the_world(mock: MockRobot) -> None:
    world = load_world("arena")
    plain = crop_map(draw_robot(mock.layered, mock.description, world=world).image)
    drawn = crop_map(draw_robot(mock.layered, mock.description, PATH, world=world).image)
    assert count_colour(plain, SERIES[0]) == 0 < count_colour(drawn, SERIES[0])
    assert world.target
    assert count_colour(drawn, world.target.colour) > 50


@pytest.mark.slow
def test_path_without_a_world_is_drawn_on_an_empty_floor(mock: MockRobot) -> None:
    drawn = crop_map(draw_robot(mock.layered, mock.description, PATH).image)
    assert count_colour(drawn, SERIES[0]) > 500
    assert count_colour(drawn, mock.description.body.colour) > 500


def test_map_takes_the_place_of_the_world(mock: MockRobot) -> None:
    grid = OccupancyGrid()
    grid.evidence[150:160, 150:190] = 1.0
    drawn = crop_map(draw_robot(mock.layered, mock.description, PATH, world=load_world("arena"), grid=grid).image)
    assert count_colour(drawn, INK) > 5000
    assert min(count_colour(drawn, SERIES[0]), count_colour(drawn, BAD)) > 100


@pytest.mark.slow
@pytest.mark.parametrize("grid", [None, OccupancyGrid()], ids=["floor", "map"])
@pytest.mark.parametrize("lost", [Pose(math.nan, 0.0, 0.0), Pose(0.0, math.inf, 0.0), Pose(0.0, 0.0, math.nan)])
def test_pose_of_an_invalid_encoder_value_is_left_out(mock: MockRobot, lost: Pose, grid: OccupancyGrid | None) -> None:
    drawn = draw_robot(mock.layered, mock.description, [*PATH, lost], grid=grid).image
    np.testing.assert_array_equal(drawn, draw_robot(mock.layered, mock.description, PATH, grid=grid).image)


def test_robot_far_outside_of_the_map_is_not_drawn() -> None:
    grid = OccupancyGrid()
    np.testing.assert_array_equal(grid.draw(Pose(1e9, 0.0, 0.0), [(-1e9, 0.0), (math.nan, 0.0)]), grid.draw())


@pytest.mark.slow
def test_picture_is_saved_and_shown_as_png(mock: MockRobot, tmp_path: Path) -> None:
    picture = draw_robot(mock.layered, mock.description, PATH)
    picture.save(str(tmp_path / "now.png"))
    for content in ((tmp_path / "now.png").read_bytes(), picture._repr_png_()):
        decoded = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
        np.testing.assert_array_equal(np.asarray(decoded), picture.image)


def test_picture_without_a_folder_is_not_written(mock: MockRobot, tmp_path: Path, raises: Raises) -> None:
    picture = draw_robot(mock.layered, mock.description)
    with raises(UsageError, "file-not-writable", file=str(tmp_path / "no" / "now.png")):
        picture.save(tmp_path / "no" / "now.png")


@pytest.mark.parametrize("name", ["now.jpg", "now"])
def test_picture_is_saved_as_nothing_but_png(mock: MockRobot, name: str, tmp_path: Path, raises: Raises) -> None:
    with raises(UsageError, "file-ending"):
        draw_robot(mock.layered, mock.description).save(tmp_path / name)
    assert list(tmp_path.iterdir()) == []
