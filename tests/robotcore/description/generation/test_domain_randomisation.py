from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from robotcore.description import (
    Conditions,
    Randomisation,
    RandomisedWorld,
    Texture,
    WorldDescription,
    draw_world,
    hue_degrees,
    load_robot,
    load_world,
    randomise,
)
from robotcore.description.generation.domain_randomisation import free_arcs, hue_at
from robotcore.errors import DescriptionError
from tests.robotcore.description.worlds import ball, box, room
from tests.texts import Raises

HUES = st.lists(st.floats(-60, 420), min_size=1, max_size=4)


def apart(one: float, other: float) -> float:
    return abs((one - other + 180) % 360 - 180)


@given(HUES, st.floats(0, 170), st.floats(0, 1))
def test_free_hue_keeps_the_gap_to_all_taken_hues(taken: list[float], gap: float, share: float) -> None:
    arcs = free_arcs(taken, gap)
    assume(arcs)
    hue = hue_at(arcs, share)
    assert min(apart(hue, other) for other in taken) >= gap - 1e-9


@given(HUES, st.floats(0, 170), st.integers(0, 359))
def test_every_hue_that_keeps_the_gap_is_in_an_arc(taken: list[float], gap: float, hue: int) -> None:
    assume(min(apart(hue, other) for other in taken) > gap + 1e-9)
    assert any((hue - start) % 360 <= length for start, length in free_arcs(taken, gap))


def test_shares_are_spread_evenly_over_the_arcs() -> None:
    arcs = free_arcs([-10, 150], 60)
    assert arcs == [(210, 80), (410, 40)]
    assert [hue_at(arcs, share) for share in (0, 0.5, 0.75, 1)] == [210, 270, 420, 450]


def test_all_hues_are_free_without_a_taken_hue() -> None:
    assert hue_at(free_arcs([], 60), 0.5) == 180


SEEDS = range(12)
ARENA = draw_world(load_world("arena"), load_robot("rover"), 7)
SEEN = {"colour", "texture"}


def drawn(world: WorldDescription = ARENA, *, seeds: Iterable[int] = SEEDS, **ranges: Any) -> list[RandomisedWorld]:
    """Return the world that each seed draws with changed ranges."""
    world = world.model_copy(update={"randomisation": Randomisation(**ranges)})
    return [randomise(world, seed) for seed in seeds]


def test_randomisation_does_not_change_the_layout() -> None:
    for world, _ in drawn():
        assert world.start == ARENA.start
        assert (world.light.azimuth_rad, world.light.elevation_rad) == (
            ARENA.light.azimuth_rad,
            ARENA.light.elevation_rad,
        )
        for thing, before in zip(world.bodies, ARENA.bodies, strict=True):
            assert thing.model_dump(exclude=SEEN) == before.model_dump(exclude=SEEN)


def test_seed_determines_the_drawn_values() -> None:
    first = drawn()
    assert first == drawn()
    assert all(one.world != other.world for one, other in combinations(first, 2))


def test_drawn_values_of_a_seed_are_those_of_earlier_versions() -> None:
    values = randomise(ARENA, 7).values
    assert (values["light_brightness"], values["camera_noise"], values["wheel_gain_left"]) == (
        0.5339,
        3.1636,
        0.9966,
    )
    assert (values["floor_pattern"], values["walls_pattern"], values["obstacles_pattern"]) == (
        "checker",
        "checker",
        "planks",
    )


def test_reported_values_are_those_of_the_world() -> None:
    for world, values in drawn():
        assert values["light_brightness"] == world.light.brightness
        assert values["light_ambient"] == world.light.ambient == pytest.approx(1 - world.light.diffuse)
        assert values["floor_hue_deg"] == pytest.approx(hue_degrees(world.floor.colour), abs=1e-3)
        assert values["target_hue_deg"] == pytest.approx(hue_degrees(world.targets[0].colour), abs=1e-3)
        assert values["floor_pattern"] == (world.floor.texture.pattern if world.floor.texture else "plain")
        assert {name: values[name] for name in Conditions.model_fields} == world.conditions.model_dump()


def test_drawn_values_cover_their_ranges() -> None:
    ranges = Randomisation().model_dump()
    for name in ("light_brightness", "light_ambient", "camera_noise", "camera_exposure", "range_bias_m", "wheel_lag_s"):
        low, high = ranges[name]
        values = [float(one.values[name]) for one in drawn()]
        assert low <= min(values) < low + (high - low) / 3
        assert high - (high - low) / 3 < max(values) <= high


@pytest.mark.parametrize("off", ["camera_noise", "patterns", "hue_gap_deg", "light_ambient", "target_value"])
def test_switching_off_a_quantity_does_not_change_the_others(off: str) -> None:
    without: dict[str, Any] = {off: False}
    for whole, part in zip(drawn(), drawn(**without), strict=True):
        group = {"hue_gap_deg": "_hue_deg", "target_value": "target_", "patterns": "_pattern"}.get(off, off)
        assert {k: v for k, v in part.values.items() if group not in k}.items() <= whole.values.items()
        assert part != whole


def test_quantity_that_is_switched_off_keeps_the_value_of_the_file() -> None:
    planks = Texture(pattern="planks")
    world = ARENA.model_copy(
        update={
            "floor": ARENA.floor.model_copy(update={"texture": planks}),
            "conditions": Conditions(camera_noise=3.0, wheel_lag_s=0.2),
        }
    )
    for one in drawn(world, patterns=False, camera_noise=False, wheel_lag_s=False, light_brightness=False):
        assert one.world.floor.texture == planks
        assert (one.world.conditions.camera_noise, one.world.conditions.wheel_lag_s) == (3.0, 0.2)
        assert one.world.light.brightness == ARENA.light.brightness
        assert not {"camera_noise", "wheel_lag_s", "light_brightness", "floor_pattern"} & one.values.keys()


@pytest.mark.parametrize("gap", [50, 60, 80])
def test_hues_keep_the_gap_to_the_targets_hues(gap: int) -> None:
    # The rounding of a colour to 8 bits changes a vivid hue by less than a fifth of a degree.
    green, blue = ball(), ball("second", colour="blue", x_m=1.0)
    vivid: dict[str, Any] = {"colour_saturation": (1.0, 1.0), "colour_value": (1.0, 1.0)}
    for world, _ in drawn(room(green, blue, box(x_m=-1.0)), seeds=range(100), hue_gap_deg=gap, **vivid):
        assert world.walls
        for colour in (world.floor.colour, world.walls.colour, world.obstacles[0].colour, world.light.sky_colour):
            assert min(apart(hue_degrees(colour), hue_degrees(one.colour)) for one in world.targets) > gap - 0.2


def test_target_keeps_about_its_hue_and_a_grey_target_stays_grey() -> None:
    for world, _ in drawn(room(ball(), ball("pale", colour="grey", x_m=1.0))):
        green, pale = world.targets
        assert apart(hue_degrees(green.colour), hue_degrees(ball().colour)) < 10
        assert len(set(pale.colour)) == 1


def test_obstacles_have_different_colours_and_the_same_pattern() -> None:
    for world, _ in drawn():
        assert len({obstacle.colour for obstacle in world.obstacles}) == len(world.obstacles)
        assert len({obstacle.texture for obstacle in world.obstacles}) == 1


def test_targets_that_leave_no_hue_are_reported_with_the_key_to_change(raises: Raises) -> None:
    balls = [ball(name, colour=name, x_m=float(place)) for place, name in enumerate(("red", "green", "blue"))]
    with raises(DescriptionError, "no-free-hue", key="randomisation.hue_gap_deg"):
        drawn(room(*balls), hue_gap_deg=80)


def test_world_without_walls_reports_no_value_of_walls() -> None:
    for world, values in drawn(load_world("open")):
        assert world.walls is None
        assert not any(name.startswith("walls") for name in values)
