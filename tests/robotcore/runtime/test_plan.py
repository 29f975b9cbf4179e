from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import pytest

from robotcore.description import Conditions, MotorDescription
from robotcore.errors import BackendMissingError, UsageError
from robotcore.hal.robot import Robot, Role
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
    return Plan.of(RunRequest("stopper", **asked))  # type: ignore[arg-type]


def test_plan_has_every_part_of_the_request(backend: RigBackend) -> None:
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
def test_rate_and_timeout_must_be_positive_numbers(key: str, value: float, raises: Raises) -> None:
    with raises(UsageError, "rate-out-of-range" if key == "rate_hz" else "not-positive"):
        plan(**{key: value})


def test_app_that_stops_behind_the_range_guard_is_refused(raises: Raises) -> None:
    with raises(UsageError, "stops-behind-guard", distance_m=0.25, speed_m_s=0.4):
        plan(settings={"distance_m": 0.25, "speed_m_s": 0.4})


@pytest.mark.parametrize("settings", [{"distance_m": 0.27, "speed_m_s": 0.4}, {"distance_m": 0.25, "speed_m_s": 0.3}])
def test_app_that_stops_before_the_range_guard_is_accepted(settings: dict[str, float]) -> None:
    assert plan(settings=settings)


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

    def test_drawn_layout_reports_its_light(self) -> None:
        drawn = plan(world="open", seed=7)
        assert drawn.world
        assert drawn.drawn == {
            "light_azimuth_rad": drawn.world.light.azimuth_rad,
            "light_elevation_rad": drawn.world.light.elevation_rad,
            "light_brightness": drawn.world.light.brightness,
        }
        assert plan(world="open").drawn == {}

    @pytest.mark.parametrize("seed", [None, 7])
    def test_fixed_conditions_of_a_world_are_reported(self, seed: int | None, tmp_path: Path) -> None:
        drawn = plan(world=_yard(tmp_path), seed=seed).drawn
        assert {name: drawn[name] for name in drawn if not name.startswith("light")} == YARD

    def test_drawn_lag_is_in_the_setup_and_not_in_the_description(self) -> None:
        found = plan(world="open", seed=7, randomise=True)
        lags = {motor.name: motor.lag_s for motor in found.setup.robot.all_of(MotorDescription)}
        assert set(lags.values()) == {found.conditions.wheel_lag_s}
        assert found.description == ROVER

    def test_randomise_without_a_seed_is_refused(self, raises: Raises) -> None:
        with raises(UsageError, "seed-missing"):
            plan(world="open", randomise=True)

    def test_backend_that_simulates_no_world_refuses_randomise(
        self, monkeypatch: pytest.MonkeyPatch, raises: Raises
    ) -> None:
        monkeypatch.setattr(RigBackend, "needs_world", False)
        with raises(UsageError, "nothing-to-randomise"):
            plan(world="open", seed=7, randomise=True)


def test_conditions_of_a_world_do_not_apply_to_a_real_robot(tmp_path: Path) -> None:
    found = plan(world=_yard(tmp_path))
    assert found.conditions == Conditions()
    assert found.setup.robot == ROVER
    assert found.drawn == {}


YARD = {"wheel_gain_left": 0.9, "wheel_lag_s": 0.3}


def _yard(folder: Path) -> str:
    """Write a world with fixed conditions. Return its file."""
    file = folder / "yard.toml"
    conditions = "".join(f"{name} = {value}\n" for name, value in YARD.items())
    file.write_text(f'name = "yard"\n[floor]\nlength_m = 4.0\nwidth_m = 4.0\n[conditions]\n{conditions}')
    return str(file)


class TestWorld:
    def test_default_world_of_a_simulator_is_the_arena(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(RigBackend, "needs_world", True)
        world = plan().world
        assert world
        assert world.name == "arena"

    def test_seed_zero_is_a_seed(self) -> None:
        assert plan(world="open", seed=0).world != plan(world="open").world
