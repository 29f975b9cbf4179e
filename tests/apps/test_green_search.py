from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import pytest

import robotcore.description
from apps.green_search import GreenSearch
from robotcore import Outcome, RunRequest, Status, run
from robotcore.errors import UsageError
from robotcore.hal.device import Device
from robotcore.kinds.encoder import Angle
from robotcore.optics import Image
from robotcore.runtime.settings import configure
from tests.robotcore.fakes import UNHURRIED, NullEncoder, Rig, picture
from tests.texts import Raises

WORLDS = Path(robotcore.description.__file__).parent / "worlds"


@pytest.mark.slow
@pytest.mark.parametrize("world", ["arena", "open", "clutter", "occluded"])
def test_finds_the_ball_in_every_shipped_world(world: str) -> None:
    result = run(RunRequest("green-search", world=world))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


@pytest.mark.slow
@pytest.mark.parametrize("seed", [101, 102, 103])
def test_finds_the_ball_in_worlds_drawn_from_a_seed(seed: int) -> None:
    result = run(RunRequest("green-search", world="arena", seed=seed))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


@pytest.mark.slow
@pytest.mark.parametrize("seed", [300, 302])
def test_finds_a_ball_behind_obstacles(seed: int) -> None:
    result = run(RunRequest("green-search", world="occluded", seed=seed))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


@pytest.mark.slow
def test_reaches_its_milestones_in_their_order() -> None:
    times = list(run(RunRequest("green-search", world="open")).milestones.items())
    assert [name for name, _ in times] == ["search", "seen", "approach", "arrived"]
    assert [time for _, time in times] == sorted(time for _, time in times)


@pytest.mark.slow
def test_decisions_depend_on_the_seed_only() -> None:
    first, again, other = (run(RunRequest("green-search", world="open", seed=seed)) for seed in (4, 4, 5))
    assert first.trace_sha256 == again.trace_sha256 != other.trace_sha256


@pytest.mark.slow
def test_searches_until_the_timeout_if_nothing_has_the_hue() -> None:
    result = run(RunRequest("green-search", world="open", settings={"hue": "magenta"}, timeout_s=20))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.TIMEOUT, False, 0)
    assert "seen" not in result.milestones


@pytest.mark.slow
@pytest.mark.parametrize(
    "fault, seed",
    [("range spikes=0.05", 4), ("encoders slip=0.05", 18), ("encoders slip=0.05", 19), ("encoders delay=0.1", 17)],
)
def test_finds_the_ball_with_faulty_sensors_in_difficult_rooms(fault: str, seed: int) -> None:
    """With these faults and seeds, an app that trusts every sample touches an obstacle or finds no path."""
    result = run(RunRequest("green-search", world="arena", seed=seed, faults=(fault,)))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


@pytest.mark.slow
@pytest.mark.parametrize("seed, fault", [(20922, "left_encoder slip=1 after=7.54 lasts=0.33")])
def test_finds_the_ball_after_a_wheel_slipped_and_the_range_guard_held_the_robot(seed: int, fault: str) -> None:
    result = run(RunRequest("green-search", world="arena", seed=seed, faults=(fault,)))
    assert (result.outcome, result.verified) == (Outcome.SUCCESS, True), result.reason


def copy_arena(folder: Path, colours: Mapping[str, str]) -> str:
    """Write a copy of the arena in which some colours are replaced, and return its path."""
    lines = (WORLDS / "arena.toml").read_text(encoding="utf-8").splitlines()
    replaced = {f'colour = "{old}"': f'colour = "{new}"' for old, new in colours.items()}
    file = folder / "my_arena.toml"
    file.write_text("\n".join(replaced.get(line, line) for line in lines), encoding="utf-8")
    return str(file)


@pytest.mark.slow
@pytest.mark.parametrize("hue, seed", [("red", 9), ("orange", 3)])
def test_finds_a_ball_of_another_hue_among_obstacles_of_similar_hues(tmp_path: Path, hue: str, seed: int) -> None:
    world = copy_arena(tmp_path, {"green": hue, hue: "green"})
    result = run(RunRequest("green-search", world=world, seed=seed, settings={"hue": hue}))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


@pytest.mark.slow
def test_red_things_are_not_found_as_orange(tmp_path: Path) -> None:
    world = copy_arena(tmp_path, {"green": "red", "orange": "red", "yellow": "white"})
    result = run(RunRequest("green-search", world=world, seed=3, settings={"hue": "orange"}, timeout_s=30))
    assert (result.outcome, "seen" in result.milestones) == (Outcome.TIMEOUT, False)


@pytest.mark.slow
def test_tolerance_keeps_similar_hues_out(tmp_path: Path) -> None:
    """From 28 degrees, red is in the range of 30 degrees and not in one of 12."""
    world = copy_arena(tmp_path, {"green": "red", "orange": "white", "yellow": "white"})
    has_seen = {}
    for tolerance in (30, 12):
        settings = {"hue": "28", "tolerance": tolerance}
        result = run(RunRequest("green-search", world=world, seed=3, settings=settings, timeout_s=15))
        has_seen[tolerance] = "seen" in result.milestones
    assert has_seen == {30: True, 12: False}


@pytest.fixture
def rig() -> Rig:
    """Return a robot that stands in front of the ball."""
    rig = Rig(description=UNHURRIED)
    rig.eye.image = draw_ball()
    rig.nose.distance = 0.28
    return rig


@pytest.fixture
def app() -> GreenSearch:
    return GreenSearch()


def draw_ball(size: int = 14) -> Image:
    """Return a picture of the ball ahead, as a green square. Its size is in pixels."""
    image = picture().copy()
    image[12 - size // 2 : 12 + size // 2, 16 - size // 2 : 16 + size // 2] = (60, 170, 40)
    return image


def play(app: GreenSearch, rig: Rig, seconds: float) -> list[str]:
    """Run the app for a time, or to its success. Return its states, and ``success``."""
    states = []
    for _ in range(round(seconds * rig.rate_hz)):
        status = app.step(rig.robot)
        states.append(app.state if status is Status.RUNNING else status.value)
        if status is not Status.RUNNING:
            break
        rig.commit()
    return list(dict.fromkeys(states))


def test_succeeds_after_half_a_second_at_the_ball(app: GreenSearch, rig: Rig) -> None:
    assert play(app, rig, 5.0) == ["search", "seen", "approach", "arrived", "success"]
    assert 0.5 < rig.clock.now() < 1.5


class RollingRig(Rig):
    """A rover whose wheels turn slowly until 2 s, and ignore the commands."""

    @property
    def devices(self) -> list[Device]:
        return [*super().devices, *(RollingEncoder(self.clock, f"{side}_encoder") for side in ("left", "right"))]


class RollingEncoder(NullEncoder):
    def _newest(self) -> Angle:
        self.angle = 0.4 * min(self._clock.now(), 2.0)
        return super()._newest()


def test_does_not_succeed_before_the_wheels_have_come_to_rest(app: GreenSearch) -> None:
    rig = RollingRig(description=UNHURRIED)
    rig.eye.image, rig.nose.distance = draw_ball(), 0.28
    assert play(app, rig, 5.0)[-1] == "success"
    assert 2.0 < rig.clock.now() < 2.5


@pytest.mark.parametrize("distance", [0.17, 0.39, math.inf])
def test_does_not_succeed_without_the_echo_of_the_ball(app: GreenSearch, rig: Rig, distance: float) -> None:
    rig.nose.distance = distance
    assert "success" not in play(app, rig, 5.0)


def test_searches_again_if_the_ball_vanishes_while_the_robot_stands_at_it(app: GreenSearch, rig: Rig) -> None:
    assert play(app, rig, 0.4)[-1] == "arrived"
    rig.eye.image = picture()
    assert play(app, rig, 2.0)[-1] == "search"


@pytest.mark.parametrize("pictures, is_driven_to", [(1, False), (3, False), (6, True)])
def test_drives_to_no_blob_that_vanishes_within_three_pictures(
    app: GreenSearch, rig: Rig, pictures: int, *, is_driven_to: bool
) -> None:
    rig.nose.distance = 1.5
    states = play(app, rig, pictures / rig.rate_hz)
    rig.eye.image = picture()
    states += play(app, rig, 0.3)
    assert ("approach" in states) == is_driven_to


def test_ball_that_no_picture_shows_on_a_free_straight_path_is_gone(app: GreenSearch, rig: Rig) -> None:
    rig.eye.image, rig.nose.distance = draw_ball(6), 1.5
    grid = app.grid
    grid.evidence[grid.disc(0.0, 0.0, 2.0)] = -1.0
    assert play(app, rig, 1.0)[-1] == "approach"
    rig.eye.image = picture()
    assert play(app, rig, 0.4)[-1] == "approach"
    assert play(app, rig, 0.2)[-1] == "search"


@pytest.mark.parametrize("tolerance", ["0", "200", "x"])
def test_tolerance_out_of_bounds_is_refused(tolerance: str, raises: Raises) -> None:
    with raises(UsageError, "setting-invalid", setting="tolerance"):
        configure(GreenSearch, {"tolerance": tolerance})
