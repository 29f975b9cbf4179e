from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import pytest

from robotcore.description import Conditions
from robotcore.errors import BackendMissingError, UsageError
from robotcore.hal.robot import Robot, Role
from robotcore.kinds.motor import MotorDescription
from robotcore.runtime.behaviour import Behaviour, Status, Stopping
from robotcore.runtime.plan import Plan, RunRequest
from tests.robotcore.fakes import ROVER, RigBackend
from tests.texts import CheckText, Raises


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
    return Plan.resolve(RunRequest("stopper", **asked))  # type: ignore[arg-type]


def test_plan_has_every_part_of_the_request(backend: RigBackend) -> None:
    found = plan(settings={"speed_m_s": "0.1"}, rate_hz=50, seed=3, options={"a": 1}, world="open")
    assert found.behaviour == Stopper(speed_m_s=0.1)
    assert found.backend is backend
    assert found.description == ROVER
    assert (found.setup.rate_hz, found.setup.seed, found.setup.options) == (50, 3, {"a": 1})
    assert found.setup.devices == {"left_motor", "right_motor", "left_encoder", "right_encoder", "nose"}
    assert found.setup.world is found.world
    assert backend.rigs == []


@pytest.mark.parametrize("key, kind", [("rate_hz", "rate-out-of-range"), ("timeout_s", "not-positive")])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_rate_and_timeout_must_be_positive_numbers(key: str, kind: str, value: float, raises: Raises) -> None:
    with raises(UsageError, kind):
        plan(**{key: value})


def test_app_that_stops_behind_the_range_guard_is_refused(raises: Raises) -> None:
    assert plan(settings={"distance_m": 0.27, "speed_m_s": 0.4})
    assert plan(settings={"distance_m": 0.25, "speed_m_s": 0.3})
    with raises(UsageError, "stops-behind-guard", distance_m=0.25, speed_m_s=0.4):
        plan(settings={"distance_m": 0.25, "speed_m_s": 0.4})


def test_backend_without_a_window_refuses_gui(check_text: CheckText) -> None:
    with pytest.raises(UsageError) as raised:
        plan(gui=True)
    assert raised.value.kind == "no-window"
    backends = raised.value.fields["backends"]
    assert isinstance(backends, list)
    assert "pybullet" in backends
    check_text(raised.value, hide=[" or ".join(backends)])


def test_missing_library_is_reported(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.setattr(RigBackend, "modules", ("no_such_simulator",))
    with raises(BackendMissingError):
        plan()


YARD = {"wheel_gain_left": 0.9, "wheel_lag_s": 0.3}


@pytest.fixture
def yard(tmp_path: Path) -> str:
    """The file of a world with fixed conditions."""
    file = tmp_path / "yard.toml"
    conditions = "".join(f"{name} = {value}\n" for name, value in YARD.items())
    file.write_text(f'name = "yard"\n[floor]\nlength_m = 4.0\nwidth_m = 4.0\n[conditions]\n{conditions}')
    return str(file)


def test_conditions_of_a_world_do_not_apply_to_a_real_robot(yard: str) -> None:
    found = plan(world=yard)
    assert (found.conditions, found.setup.robot, found.drawn) == (Conditions(), ROVER, {})


@pytest.mark.parametrize("needs_world, seed, kind", [(True, None, "seed-missing"), (False, 7, "nothing-to-randomise")])
def test_randomise_needs_a_seed_and_a_simulated_world(
    monkeypatch: pytest.MonkeyPatch, needs_world: bool, seed: int | None, kind: str, raises: Raises
) -> None:
    monkeypatch.setattr(RigBackend, "needs_world", needs_world)
    with raises(UsageError, kind):
        plan(world="open", seed=seed, randomise=True)


class TestRandomise:
    @pytest.fixture(autouse=True)
    def simulator(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(RigBackend, "needs_world", True)

    def test_layout_is_the_same_and_the_drawn_values_are_reported(self) -> None:
        plain, other = plan(world="open", seed=7), plan(world="open", seed=7, randomise=True)
        assert plain.world
        assert other.world
        assert (other.world.start, other.world.targets[0].x_m) == (plain.world.start, plain.world.targets[0].x_m)
        assert other.world.floor != plain.world.floor
        assert other.drawn["camera_noise"] == other.conditions.camera_noise > 0
        assert plain.drawn.keys() < other.drawn.keys()

    def test_default_world_is_the_arena_and_a_drawn_layout_reports_its_light(self) -> None:
        drawn, plain = plan(seed=0), plan()
        assert drawn.world
        assert plain.world
        assert drawn.world.name == plain.world.name == "arena"
        assert drawn.world != plain.world
        assert drawn.drawn == {
            "light_azimuth_rad": drawn.world.light.azimuth_rad,
            "light_elevation_rad": drawn.world.light.elevation_rad,
            "light_brightness": drawn.world.light.brightness,
        }
        assert plain.drawn == {}

    @pytest.mark.parametrize("seed", [None, 7])
    def test_fixed_conditions_of_a_world_are_reported(self, seed: int | None, yard: str) -> None:
        drawn = plan(world=yard, seed=seed).drawn
        assert {name: drawn[name] for name in drawn if not name.startswith("light")} == YARD

    def test_drawn_lag_is_in_the_setup_and_not_in_the_description(self) -> None:
        found = plan(world="open", seed=7, randomise=True)
        lags = {motor.name: motor.lag_s for motor in found.setup.robot.all_of(MotorDescription)}
        assert set(lags.values()) == {found.conditions.wheel_lag_s}
        assert found.description == ROVER


def test_app_in_place_of_a_request_is_refused(raises: Raises) -> None:
    with raises(UsageError, "not-a-request"):
        Plan.resolve(Behaviour)  # type: ignore[arg-type]
