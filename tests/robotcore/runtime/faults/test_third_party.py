"""A fault of somebody else's, found by its entry point."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import EntryPoint
from typing import Annotated

import pytest
from pydantic import Field

from robotcore import plugins as registry
from robotcore.cli.main import execute
from robotcore.errors import BackendMissingError, UsageError
from robotcore.hal.devices import Range, RangeSensor
from robotcore.runtime.faults import Fault, Kind, Occasion, plan_faults
from robotcore.runtime.faults.planning import load_fault
from robotcore.runtime.layers.base import Layer, Reader
from robotcore.sweep.fingerprint import code_digest
from tests.robotcore.fakes import ROVER
from tests.robotcore.runtime.faults.rigs import faulty

Register = Callable[[str, str], None]


class Bias(Fault):
    """Adds this to each distance.

    A wall that is not where it seems.
    """

    on = frozenset({Kind.RANGE})
    example = "range bias=0.1"

    value: Annotated[float, Field(ge=-1, le=1, description="metres")]
    mode: str = "plain"

    def layer(self, occasion: Occasion) -> Layer:
        return Biased(self)


class Biased(Layer):
    def __init__(self, fault: Bias) -> None:
        self._fault = fault

    def range_sensor(self, sensor: RangeSensor, read: Reader[Range]) -> Reader[Range]:
        return lambda: replace(read(), distance=read().distance + self._fault.value)


@pytest.fixture
def register(monkeypatch: pytest.MonkeyPatch) -> Register:
    """Add an entry point to those that are installed."""

    def add(name: str, value: str) -> None:
        points = {group: dict(registry._points(group)) for group in (registry.APPS, registry.BACKENDS, registry.FAULTS)}
        points[registry.FAULTS][name] = EntryPoint(name, value, registry.FAULTS)
        monkeypatch.setattr("robotcore.plugins._points", points.get)

    return add


def test_it_works_like_one_of_ours(register: Register) -> None:
    register("bias", f"{__name__}:Bias")
    rig = faulty("nose bias=0.25")
    rig.nose.distance = 1.0
    assert rig.robot.range.read().distance == 1.25


def test_its_parameters_are_checked_like_ours(register: Register) -> None:
    register("bias", f"{__name__}:Bias")
    with pytest.raises(UsageError, match=r"bias should be at most 1.*\n.*range bias=METRES \[after=SECONDS\]"):
        plan_faults(["range bias=2"], ROVER, {"nose"})
    (planned,) = plan_faults(["range bias=0.1 mode=odd"], ROVER, {"nose"})
    assert isinstance(planned.fault, Bias)
    assert planned.fault.mode == "odd"


def test_an_effect_of_ours_may_be_had_on_another_kind_of_device(register: Register) -> None:
    register("weak.range", f"{__name__}:Bias")
    names = {"nose", "left_motor"}
    weak = plan_faults(["range weak=-0.5", "left_motor weak=0.5"], ROVER, names)
    assert [type(planned.fault).__name__ for planned in weak] == ["Bias", "Weak"]


def test_an_installation_from_before_there_were_faults_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_points", lambda _: {})
    with pytest.raises(UsageError, match=r"no fault is registered. Install the project first: pip install -e ."):
        plan_faults(["range drop=0.1"], ROVER, {"nose"})


def test_its_code_counts_for_the_results_of_a_sweep(register: Register) -> None:
    register("bias", f"{__name__}:Bias")
    ours, without = (code_digest((), (), faults) for faults in (["range drop=0.1", "range"], ()))
    assert ours == without
    assert code_digest((), (), ["range bias=0.1"]) != without


def test_it_is_listed(register: Register, capsys: pytest.CaptureFixture[str]) -> None:
    register("bias", f"{__name__}:Bias")
    assert execute(["faults", "--json"]) == 0
    bias = next(fault for fault in json.loads(capsys.readouterr().out) if fault["name"] == "bias")
    assert bias["on"] == ["range"]
    assert bias["summary"] == "Adds this to each distance."
    assert bias["parameters"][:1] == [{"name": "bias", "unit": "metres", "limits": "from -1 to 1", "required": True}]
    assert execute(["faults"]) == 0
    assert "bias: metres, from -1 to 1" in capsys.readouterr().out


@pytest.mark.parametrize("value", ["no_such_package:Thing", f"{__name__}:Biased", f"{__name__}:ROVER"])
def test_one_that_is_broken_is_told_and_hides_no_other(
    register: Register, capsys: pytest.CaptureFixture[str], value: str
) -> None:
    register("broken", value)
    with pytest.raises(BackendMissingError, match=r"the fault 'broken'"):
        load_fault("broken")
    assert execute(["faults"]) == 0
    told = capsys.readouterr().out
    assert "broken" in told
    assert "camera drop=0.2 after=5" in told
    with pytest.raises(UsageError, match="on a motor there are: dead, lost, reversed, weak"):
        plan_faults(["left_motor drop=1"], ROVER, {"left_motor"})
