from __future__ import annotations

from functools import cache
from itertools import combinations

import pytest

from robotcore.description import (
    Variation,
    WorldDescription,
    draw_world,
    is_solvable,
    load_robot,
    load_world,
    require_room,
    require_start,
    world_names,
)
from robotcore.description.generation.gaps import compute_gap, gap_to_edge
from robotcore.description.generation.reachability import is_target_hidden, is_target_in_view
from robotcore.description.lines import LineDistances
from robotcore.description.world import round_outline
from robotcore.errors import DescriptionError, UsageError
from tests.robotcore.description.worlds import ball, box, room
from tests.texts import Raises

ROVER, LOOKOUT = load_robot("rover"), load_robot("lookout")
SEEDS = range(12)
DRAWN = [name for name in world_names() if name != "bench"]
"""The worlds whose layout a seed draws. The world bench is for calibrations."""

WITH_TARGET = [name for name in DRAWN if load_world(name).target]
EVERYWHERE = Variation(place_x_m=(-2, 2), place_y_m=(-2, 2))


@cache
def draws(name: str, robot: str = "rover") -> list[WorldDescription]:
    return [draw_world(load_world(name), load_robot(robot), seed) for seed in SEEDS]


def varied(world: WorldDescription, variation: Variation | None) -> WorldDescription:
    return world.model_copy(update={"variation": variation})


@pytest.mark.slow
@pytest.mark.parametrize("name", WITH_TARGET)
def test_seed_determines_the_layout(name: str) -> None:
    first = draws(name)
    draws.cache_clear()
    assert first == draws(name)
    for part in ("start", "targets", "light"):
        assert len({getattr(drawn, part) for drawn in first}) == len(SEEDS)


def test_seed_draws_the_start_on_the_line_of_the_track() -> None:
    (line,) = load_world("track").lines
    starts = [drawn.start for drawn in draws("track", "tracer")]
    assert len(set(starts)) == len(SEEDS)
    assert all(LineDistances(line).locate(start.x_m, start.y_m)[0] < 0.03 for start in starts)
    assert all(drawn.lines == (line,) for drawn in draws("track", "tracer"))


def test_drawn_values_of_a_seed_are_those_of_earlier_versions() -> None:
    drawn = draw_world(load_world("open"), ROVER, 7)
    assert drawn.start.x_m == pytest.approx(-1.710254853329829, abs=1e-9)
    assert drawn.targets[0].y_m == pytest.approx(-1.6371479466245398, abs=1e-9)


@pytest.mark.parametrize("name", WITH_TARGET)
def test_drawn_world_is_solvable_and_its_target_has_the_distance_and_the_visibility_of_the_file(name: str) -> None:
    for drawn in draws(name):
        require_room(drawn, "drawn")
        require_start(drawn, ROVER)
        assert is_solvable(drawn, ROVER)
        assert drawn.variation
        assert drawn.variation.target_distance_m
        nearest, farthest = drawn.variation.target_distance_m
        target = drawn.targets[0]
        assert nearest <= drawn.start.pose.distance_to(target.x_m, target.y_m) <= farthest
        assert is_target_hidden(drawn, ROVER) or not drawn.variation.target_hidden


@pytest.mark.parametrize("name", DRAWN)
def test_robot_can_turn_at_the_start_and_pass_between_any_two_bodies_and_along_every_wall(name: str) -> None:
    width = 2 * ROVER.body.reach_m
    for drawn in draws(name):
        for one, other in combinations(drawn.bodies, 2):
            assert compute_gap(one.outline, other.outline) > width
        disc = round_outline(drawn.start.x_m, drawn.start.y_m, ROVER.body.reach_m + 0.045)
        assert gap_to_edge(disc, drawn.floor) > 0
        for thing in drawn.bodies:
            assert gap_to_edge(thing.outline, drawn.floor) > (width if drawn.walls else 0)
            assert compute_gap(disc, thing.outline) > 0


def test_obstacles_are_scaled_in_length_and_width_only() -> None:
    written = load_world("clutter").obstacles[0]
    scales = []
    for drawn in draws("clutter"):
        obstacle = drawn.obstacles[0]
        assert obstacle.height_m == written.height_m
        assert obstacle.shape == written.shape == "box"
        assert obstacle.length_m / written.length_m == pytest.approx(obstacle.width_m / written.width_m)
        scales.append(obstacle.length_m / written.length_m)
    assert 0.8 <= min(scales) < max(scales) <= 1.3


@pytest.mark.parametrize("name", WITH_TARGET)
def test_robot_that_cannot_drive_starts_with_the_target_in_view(name: str) -> None:
    assert all(is_target_in_view(drawn, LOOKOUT) for drawn in draws(name, "lookout"))


def test_values_without_an_interval_do_not_change() -> None:
    touching = room(box(), box("leg", x_m=0.4), ball(x_m=1.2))
    drawn = draw_world(varied(touching, Variation(light_brightness=(0.5, 0.6))), ROVER, 1)
    assert 0.5 <= drawn.light.brightness <= 0.6
    assert (drawn.start, drawn.obstacles, drawn.targets) == (
        touching.start,
        touching.obstacles,
        touching.targets,
    )


def test_distance_interval_applies_only_to_the_first_target() -> None:
    near = EVERYWHERE.model_copy(update={"target_distance_m": (0.5, 1.0)})
    world = varied(room(ball(), ball("second"), ball("third")), near)
    for seed in SEEDS:
        drawn = draw_world(world, ROVER, seed)
        first, *others = [drawn.start.pose.distance_to(target.x_m, target.y_m) for target in drawn.targets]
        assert first <= 1.0
        if max(others) > 1.0:
            return
    pytest.fail("every target kept the first one's distance")


def test_variation_of_the_light_alone_does_not_move_bodies(raises: Raises) -> None:
    barred = room(box(length_m=0.1, width_m=4.0), ball(x_m=1.3))
    with raises(DescriptionError, "no-path", key="variation.gap_m", seed=3):
        draw_world(varied(barred, Variation(light_brightness=(0.5, 0.6))), ROVER, 3)


def test_gap_is_at_least_wide_enough_for_the_robot() -> None:
    body = ROVER.body.model_copy(update={"width_m": 0.4})
    wide = ROVER.model_copy(update={"body": body})
    world = varied(room(*(box(f"box-{n}", length_m=0.2, width_m=0.2) for n in range(4)), ball()), EVERYWHERE)
    drawn = draw_world(world, wide, 2)
    assert min(compute_gap(a.outline, b.outline) for a, b in combinations(drawn.bodies, 2)) > 2 * body.reach_m


@pytest.mark.slow
@pytest.mark.parametrize(
    "world, update, kind, key",
    [
        (room(box(), ball(x_m=1.0)), {"gap_m": 1.9}, "no-obstacle-room", "gap_m"),
        (room(box()), {"place_x_m": (-0.01, 0.01), "place_y_m": (-0.01, 0.01)}, "no-start-room", "place_x_m"),
        (room(ball()), {"gap_m": 1.95}, "no-target-room", "gap_m"),
        (room(ball()), {"target_distance_m": (8.0, 9.0)}, "no-target-distance", "target_distance_m"),
        (room(ball()), {"target_hidden": True}, "no-target-hidden", "target_hidden"),
    ],
    ids=["obstacles", "start", "target", "distance", "hidden"],
)
def test_constraint_that_cannot_be_met_is_reported_with_the_key_to_change(
    raises: Raises, world: WorldDescription, update: dict[str, object], kind: str, key: str
) -> None:
    impossible = varied(world, EVERYWHERE.model_copy(update=update))
    with raises(DescriptionError, kind, key=f"variation.{key}", seed=3):
        draw_world(impossible, ROVER, 3)


def test_negative_seed_is_refused_because_random_ignores_the_sign(raises: Raises) -> None:
    with raises(UsageError, "negative-seed", seed=-1):
        draw_world(load_world("open"), ROVER, -1)
