from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import pytest

from robotcore.description import Conditions, MotorDescription
from robotcore.errors import BackendMissingError, UnknownNameError, UnmetNeedError, UsageError
from robotcore.hal.robot import Robot, Role
from robotcore.runtime.behaviour import Behaviour, Status, Stopping
from robotcore.runtime.plan import Plan, RunRequest
from tests.robotcore.fakes import ROVER, RigBackend


@dataclass
class Stopper(Behaviour):
    distance_m: float = 0.3
    speed_m_s: float = 0.2

    needs = frozenset({Role.DRIVE})

    @property
    def stopping(self) -> Stopping:
        return Stopping(self.distance_m, self.speed_m_s)

    def step(self, robot: Robot) -> Status:
        return Status.SUCCESS


@pytest.fixture(autouse=True)
def backend(monkeypatch: pytest.MonkeyPatch) -> RigBackend:
    backend = RigBackend()
    monkeypatch.setattr("robotcore.runtime.plan.load_backend", lambda _: backend)
    monkeypatch.setattr("robotcore.runtime.plan.load_app", lambda _: Stopper)
    return backend


def plan(**asked: object) -> Plan:
    return Plan.of(RunRequest("stopper", **asked))  # type: ignore[arg-type]


def test_everything_that_is_named_is_found(backend: RigBackend) -> None:
    found = plan(settings={"speed_m_s": "0.1"}, rate_hz=50, seed=3, options={"a": 1}, world="open")
    assert found.behaviour == Stopper(speed_m_s=0.1)
    assert found.backend is backend
    assert found.description == ROVER
    assert (found.setup.rate_hz, found.setup.seed, found.setup.options) == (50, 3, {"a": 1})
    assert found.setup.devices == {"left_motor", "right_motor", "left_encoder", "right_encoder", "nose"}
    assert found.setup.world is found.world
    assert backend.rigs == []


@pytest.mark.parametrize("key", ["rate_hz", "timeout_s"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_a_rate_or_timeout_that_is_none_is_refused(key: str, value: float) -> None:
    with pytest.raises(UsageError, match=r"it must be (a positive number|from 1 to 1000)"):
        plan(**{key: value})


def test_an_app_that_stops_nearer_than_the_guard_acts_is_refused_with_both_distances() -> None:
    with pytest.raises(UsageError, match=r"stops 0.25 m .* at 0.4 m/s .* 'rover' acts at 0.26 m"):
        plan(settings={"distance_m": 0.25, "speed_m_s": 0.4})


@pytest.mark.parametrize("settings", [{"distance_m": 0.27, "speed_m_s": 0.4}, {"distance_m": 0.25, "speed_m_s": 0.3}])
def test_farther_away_or_slower_it_is_not(settings: dict[str, float]) -> None:
    assert plan(settings=settings)


def test_a_need_that_cannot_be_met_is_refused() -> None:
    with pytest.raises(UnmetNeedError, match="'lookout' has no drive"):
        plan(robot="lookout")


@pytest.mark.parametrize("key, name", [("robot", "rovr"), ("world", "opn")])
def test_unknown_descriptions_offer_the_nearest(key: str, name: str) -> None:
    with pytest.raises(UnknownNameError, match="Did you mean"):
        plan(**{key: name})


def test_a_backend_without_a_window_refuses_one() -> None:
    with pytest.raises(UsageError, match=r"'rig' opens no window.* or take --backend .*pybullet"):
        plan(gui=True)


def test_a_library_that_is_missing_is_reported(backend: RigBackend, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(RigBackend, "modules", ("no_such_simulator",))
    with pytest.raises(BackendMissingError, match="'rig' is not installed"):
        plan()


class TestRandomise:
    @pytest.fixture(autouse=True)
    def simulator(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(RigBackend, "needs_world", True)

    def test_it_keeps_the_layout_and_tells_what_it_drew(self) -> None:
        plain, other = plan(world="open", seed=7), plan(world="open", seed=7, randomise=True)
        assert plain.world
        assert other.world
        assert (other.world.start, other.world.targets[0].x_m) == (plain.world.start, plain.world.targets[0].x_m)
        assert other.world.floor != plain.world.floor
        assert other.drawn["camera_noise"] == other.conditions.camera_noise > 0
        assert plain.drawn.keys() < other.drawn.keys()

    def test_a_layout_tells_its_light_and_a_world_as_it_stands_nothing(self) -> None:
        drawn = plan(world="open", seed=7)
        assert drawn.world
        assert drawn.drawn == {
            "light_azimuth_rad": drawn.world.light.azimuth_rad,
            "light_elevation_rad": drawn.world.light.elevation_rad,
            "light_brightness": drawn.world.light.brightness,
        }
        assert plan(world="open").drawn == {}

    def test_what_a_picture_gets_of_light_and_exposure_is_reported_where_both_are_drawn(self) -> None:
        drawn = plan(world="open", seed=7, randomise=True).drawn
        light, exposure = drawn["light_brightness"], drawn["camera_exposure"]
        assert isinstance(light, float)
        assert isinstance(exposure, float)
        assert drawn["picture_brightness"] == pytest.approx(light * exposure, abs=1e-4)

    @pytest.mark.parametrize("seed", [None, 7])
    def test_conditions_that_a_world_fixes_are_reported(self, seed: int | None, tmp_path: Path) -> None:
        drawn = plan(world=_yard(tmp_path), seed=seed).drawn
        assert {name: drawn[name] for name in drawn if not name.startswith("light")} == YARD

    def test_a_condition_that_is_drawn_is_reported_instead_of_the_one_that_is_fixed(self, tmp_path: Path) -> None:
        found = plan(world=_yard(tmp_path), seed=7, randomise=True)
        assert found.drawn["wheel_lag_s"] == found.conditions.wheel_lag_s != YARD["wheel_lag_s"]

    def test_wheels_lag_in_the_simulator_and_not_in_the_description_that_the_layers_know(self) -> None:
        found = plan(world="open", seed=7, randomise=True)
        lags = {motor.name: motor.lag_s for motor in found.setup.robot.all_of(MotorDescription)}
        assert set(lags.values()) == {found.conditions.wheel_lag_s}
        assert found.description == ROVER

    def test_without_a_seed_it_is_refused(self) -> None:
        with pytest.raises(UsageError, match=r"--randomise draws from the seed.*--seed 7"):
            plan(world="open", randomise=True)

    def test_a_backend_that_simulates_no_world_refuses_it(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(RigBackend, "needs_world", False)
        with pytest.raises(UsageError, match=r"'rig' makes no world for this robot.*--backend kinematic"):
            plan(world="open", seed=7, randomise=True)


def test_the_conditions_of_a_world_do_not_touch_a_robot_that_is_not_simulated(tmp_path: Path) -> None:
    found = plan(world=_yard(tmp_path))
    assert found.conditions == Conditions()
    assert found.setup.robot == ROVER
    assert found.drawn == {}


YARD = {"wheel_gain_left": 0.9, "wheel_lag_s": 0.3}


def _yard(folder: Path) -> str:
    """Write a world with conditions of its own; return its file."""
    file = folder / "yard.toml"
    conditions = "".join(f"{name} = {value}\n" for name, value in YARD.items())
    file.write_text(f'name = "yard"\n[floor]\nlength_m = 4.0\nwidth_m = 4.0\n[conditions]\n{conditions}')
    return str(file)


class TestWorld:
    def test_a_backend_that_needs_none_gets_none(self) -> None:
        assert plan().world is None

    def test_a_simulator_gets_the_arena_where_none_is_named(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(RigBackend, "needs_world", True)
        world = plan().world
        assert world
        assert world.name == "arena"

    def test_a_seed_draws_it_anew_and_always_alike(self) -> None:
        plain, first, again, other = (plan(world="open", seed=seed).world for seed in (None, 1, 1, 2))
        assert first == again
        assert first != plain
        assert first != other

    def test_seed_zero_is_a_seed(self) -> None:
        assert plan(world="open", seed=0).world != plan(world="open").world
