"""Kinds of another package with mistakes: each is an error with the kind, the device and a remedy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Annotated, Any

import pytest

from drivers.kinematic.simulation import Simulation
from robotcore import plugins as registry
from robotcore.description import load_robot, load_world
from robotcore.errors import BackendMissingError, DescriptionError, DeviceError, UsageError
from robotcore.hal.backend import Setup
from robotcore.hal.device import Unit
from robotcore.hal.kind import Kind, _sensor_class, build_sensor, load_kind, simulate_device
from robotcore.hal.simulation_state import SimulationState
from robotcore.plugins import kind_names
from tests.doubles.foreign_kinds import KINDS, Gripper, GripperDescription, Tilt, TiltDescription, TiltSensor
from tests.robotcore.description.files import ROVER
from tests.texts import Raises


@pytest.fixture
def state() -> SimulationState:
    world = load_world("open")
    return Simulation(Setup(load_robot("rover"), world, frozenset()), world).simulation_state


def fail(*_arguments: Any) -> Any:
    raise ValueError("no such limit")


LINE = f"test_kind.py:{fail.__code__.co_firstlineno + 1}"
SIMULATIONS: dict[str, Any] = {
    "raises-at-the-opening": fail,
    "raises-in-a-read": lambda _description, _state: fail,
    "returns-no-function": lambda _description, _state: 3,
    "returns-no-sample": lambda _description, _state: lambda _time, _sequence: 3.0,
}


@pytest.mark.parametrize("simulate", SIMULATIONS.values(), ids=SIMULATIONS)
def test_simulation_with_a_mistake_is_an_error_of_the_device(
    simulate: Callable[..., Any], state: SimulationState, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    kind = replace(KINDS["tilt_sensor"], simulate=simulate)
    monkeypatch.setattr("robotcore.hal.kind.load_registered", lambda *_: kind)
    with raises(DeviceError, "simulation-failed", hide=[LINE]):
        sensor: Any = simulate_device(TiltDescription(name="tilt"), state)
        sensor.read()


def test_constructor_without_its_arguments_is_an_error_of_the_device(
    monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    class ScaledTilt(TiltSensor):
        def __init__(self, name: str, *, gain: float) -> None:
            super().__init__(name)
            self.gain = gain

    kind = replace(KINDS["tilt_sensor"], device=ScaledTilt)
    monkeypatch.setattr("robotcore.hal.kind.load_registered", lambda *_: kind)
    monkeypatch.setattr("robotcore.hal.kind._sensor_class", _sensor_class.__wrapped__)  # without the cache
    with raises(DeviceError, "wrong-arguments", device="tilt"):
        build_sensor(TiltDescription(name="tilt"), lambda: None)


def test_constructor_that_fails_is_an_error_of_the_device(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    class BrokenTilt(TiltSensor):
        def __init__(self, name: str) -> None:
            raise LookupError(name)

    kind = replace(KINDS["tilt_sensor"], device=BrokenTilt)
    monkeypatch.setattr("robotcore.hal.kind.load_registered", lambda *_: kind)
    monkeypatch.setattr("robotcore.hal.kind._sensor_class", _sensor_class.__wrapped__)  # without the cache
    with raises(DeviceError, "driver-error", device="tilt"):
        build_sensor(TiltDescription(name="tilt"), lambda: None)


@pytest.mark.parametrize("values", [(0.1, 0.2, 0.5), ("steep", 0.2, 3)], ids=["no-whole-number", "a-text"])
def test_simulated_sample_that_does_not_fit_its_types_is_an_error_of_the_device(
    values: Any, state: SimulationState, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    kind = replace(KINDS["tilt_sensor"], simulate=lambda *_: partial(Tilt, *values))
    monkeypatch.setattr("robotcore.hal.kind.load_registered", lambda *_: kind)
    sensor: Any = simulate_device(TiltDescription(name="tilt"), state)
    with raises(DeviceError, "sample-types", device="tilt"):
        sensor.read()


def test_simulation_of_an_actuator_that_fails_is_an_error_of_the_device(
    state: SimulationState, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    kind = replace(KINDS["gripper"], simulate=lambda _description, _state: fail)
    monkeypatch.setattr("robotcore.hal.kind.load_registered", lambda *_: kind)
    gripper: Any = simulate_device(GripperDescription(name="hand"), state)
    with raises(DeviceError, "simulation-failed", hide=[LINE], device="hand"):
        gripper.send(0.05)


def test_classes_of_different_kinds_are_refused(raises: Raises) -> None:
    with raises(UsageError, "kind-names-differ"):
        Kind("a gripper", TiltDescription, Gripper)


@dataclass(frozen=True)
class Colour:
    """A sample whose number and tuple have no unit."""

    rgb: tuple[float, ...]
    clear: float
    label: str
    time: float
    sequence: int


@dataclass
class Level:
    """A sample that can be changed."""

    level: Annotated[float, Unit("m")]
    time: float
    sequence: int


@pytest.mark.parametrize("sample, kind", [(Colour, "no-unit"), (Level, "sample-not-frozen")])
def test_kind_with_an_unsuitable_class_of_samples_is_refused(sample: type, kind: str, raises: Raises) -> None:
    with raises(UsageError, kind):
        Kind("a tilt sensor", TiltDescription, TiltSensor, sample)


def test_kind_of_a_sensor_without_a_class_of_samples_is_refused(raises: Raises) -> None:
    with raises(UsageError, "no-sample"):
        Kind("a tilt sensor", TiltDescription, TiltSensor, float)


def register(monkeypatch: pytest.MonkeyPatch, kind: str, value: str) -> None:
    points = {**registry._points(registry.KINDS), kind: EntryPoint(kind, value, registry.KINDS)}
    others = registry._points
    monkeypatch.setattr(registry, "_points", lambda group: points if group == registry.KINDS else others(group))


def write_robot(folder: Path, kind: str) -> str:
    file = folder / "my.toml"
    file.write_text(f'{ROVER}\n[[devices]]\nkind = "{kind}"\nname = "spare"\n')
    return str(file)


@pytest.mark.parametrize("value", ["no_such_module:KIND", f"{__name__}:SIMULATIONS", "robotcore.kinds.led:KIND"])
def test_kind_that_cannot_be_loaded_is_reported_where_a_robot_has_it(
    value: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    register(monkeypatch, "wheel", value)
    with raises(DescriptionError, "unknown-tag", key="devices[spare].kind"):
        load_robot(write_robot(tmp_path, "wheel"))
    with pytest.raises(BackendMissingError):
        load_kind("wheel")


def test_kind_that_no_package_registers_says_how_to_get_it(tmp_path: Path, raises: Raises) -> None:
    with raises(DescriptionError, "unknown-tag", hide=[", ".join(kind_names())]):
        load_robot(write_robot(tmp_path, "wxyz"))
