from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from robotcore.description import load_world
from robotcore.hal.devices import Image
from robotcore.view.overhead import Chart
from robotcore.view.palette import BAD, FAIR, GOOD, state_colours
from robotcore.view.sheet import _EDGE, _MAP, _SIDE, _TOP, Story, draw
from robotcore.view.track import Track

Rgb = tuple[int, int, int]


def colours_near(image: Image, x: float, y: float, reach: int = 2) -> list[Rgb]:
    """The colours, red first, around a place of the sheet."""
    column, row = round(x), round(y)
    patch = image[row - reach : row + reach + 1, column - reach : column + reach + 1, ::-1].reshape(-1, 3)
    return [(int(red), int(green), int(blue)) for red, green, blue in patch]


def on_sheet(story: Story, x: float, y: float) -> tuple[float, float]:
    """Where a point of the world lies on the sheet."""
    assert story.world
    column, row = Chart.fitting(story.world, story.track, _MAP).at(x, y)
    return column + _EDGE, row + _TOP


def test_the_ball_has_its_colour_where_it_lies(story: Story) -> None:
    assert story.world
    assert story.world.target
    ball = story.world.target
    around = [(ball.x_m + dx, ball.y_m + dy) for dx, dy in ((0, 0), (-0.06, 0), (0, -0.06))]
    image = draw(story)
    assert all(ball.colour in colours_near(image, *on_sheet(story, *place)) for place in around)


def test_every_obstacle_has_its_colour_in_its_middle(story: Story) -> None:
    assert story.world
    image = draw(story)
    for thing in story.world.obstacles:
        assert thing.colour in colours_near(image, *on_sheet(story, thing.x_m, thing.y_m))


def test_north_is_up_and_east_is_right(story: Story) -> None:
    x, y = on_sheet(story, 0.0, 0.0)
    east, north = on_sheet(story, 1.0, 0.0), on_sheet(story, 0.0, 1.0)
    assert east[0] > x
    assert north[1] < y
    assert east[1] - y == north[0] - x == 0


def test_the_path_has_the_colour_of_its_state_all_along(story: Story) -> None:
    image = draw(story)
    colours = state_colours(story.track.states)
    for step in story.track.steps[16:34:4]:
        assert colours[step.state] in colours_near(image, *on_sheet(story, step.pose.x, step.pose.y), reach=4)


def test_the_robot_stands_where_it_ended(story: Story) -> None:
    pose = story.track.steps[-1].pose
    belly = pose.to_world(0.05, 0.06)
    assert story.robot.body.colour in colours_near(draw(story), *on_sheet(story, *belly))


def test_milestones_at_one_place_do_not_hide_each_other(story: Story) -> None:
    story.track.steps = [step._replace(pose=story.track.steps[0].pose) for step in story.track.steps]
    image = draw(story)
    x, y = on_sheet(story, *story.track.steps[0].pose[:2])
    row = {tuple(int(part) for part in pixel) for pixel in image[round(y), round(x) : round(x) + 90, ::-1]}
    assert set(state_colours(story.track.states).values()) <= row


def test_a_robot_that_left_the_floor_is_still_on_the_map(story: Story) -> None:
    far = story.track.steps[-1].pose._replace(x=5.0, y=-0.3)
    story.track.steps.append(story.track.steps[-1]._replace(pose=far))
    x, _ = on_sheet(story, far.x + story.robot.body.reach_m, far.y)
    assert x < _EDGE + _MAP


@pytest.mark.parametrize("shape", [(240, 320, 3), (240, 320), (480, 320, 3)])
def test_the_last_picture_is_beside_the_map_in_colour_or_grey(story: Story, shape: tuple[int, ...]) -> None:
    seen = np.full(shape, 77, np.uint8)
    image = draw(dataclasses.replace(story, seen=seen))
    assert colours_near(image, _SIDE + 40, _TOP + 40) == [(77, 77, 77)] * 25


@pytest.mark.parametrize("verified, is_green", [(True, True), (None, True), (False, False)])
def test_success_is_green_unless_the_simulator_does_not_agree(
    story: Story, *, verified: bool | None, is_green: bool
) -> None:
    title = draw(dataclasses.replace(story, result=dataclasses.replace(story.result, verified=verified)))[80:_TOP]
    assert ((title[..., ::-1] == GOOD).all(axis=2).any(), (title[..., ::-1] == BAD).all(axis=2).any()) == (
        is_green,
        not is_green,
    )


def test_a_rehearsal_is_no_success_of_its_own(story: Story) -> None:
    title = draw(dataclasses.replace(story, recorded=story.result))[:_TOP, :, ::-1]
    assert [(title == colour).all(axis=2).any() for colour in (GOOD, BAD, FAIR)] == [False, False, True]


def test_without_a_camera_a_world_or_a_truth_there_is_still_a_sheet(story: Story) -> None:
    bare = Story(story.robot, None, Track(), None, story.result)
    assert draw(bare).shape == (1000, 1600, 3)


@pytest.mark.parametrize("world", ["arena", "clutter", "occluded", "open"])
def test_every_shipped_world_can_be_drawn(story: Story, world: str) -> None:
    assert draw(dataclasses.replace(story, world=load_world(world))).std() > 20


def test_more_states_than_colours_begin_anew() -> None:
    colours = state_colours([str(number) for number in range(20)])
    assert len(colours) == 20
    assert len(set(list(colours.values())[:8])) == 8
