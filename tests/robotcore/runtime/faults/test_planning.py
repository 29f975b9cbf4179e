"""Targets of faults, and faults of another package."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Annotated, Any

import pytest
from pydantic import Field

from robotcore.cli.main import execute
from robotcore.description import load_robot
from robotcore.errors import BackendMissingError, UsageError
from robotcore.hal.device import Sensor
from robotcore.hal.robot import Role
from robotcore.kinds import Camera, Encoder, Motor, RangeSensor
from robotcore.kinds.battery import BatteryDescription
from robotcore.kinds.bumper import BumperDescription
from robotcore.runtime.faults import ConnectionTarget, Fault, FaultContext, LoopTarget, plan_faults
from robotcore.runtime.faults.planning import load_fault
from robotcore.runtime.faults.spec import Spec
from robotcore.runtime.faults.targets import FaultTarget, TargetClass
from robotcore.runtime.layers.base import Layer, Reader
from robotcore.runtime.needs import needed_devices
from robotcore.sweep.fingerprint import compute_code_digests
from tests.robotcore.fakes import ROVER
from tests.robotcore.runtime.faults.conftest import Register
from tests.robotcore.runtime.faults.rigs import build_rig, build_rover
from tests.texts import Raises

LOOKOUT = load_robot("lookout")
DRIVING = needed_devices(ROVER, {Role.DRIVE})
EVERYTHING = frozenset(device.name for device in ROVER.devices)
BUMPY = build_rover(
    BumperDescription(kind="bumper", name="front"),
    BumperDescription(kind="bumper", name="rear"),
    BatteryDescription(kind="battery", name="cells"),
)


@pytest.mark.parametrize(
    "spec, kind, devices",
    [
        ("eye drop=0.1", Camera, {"eye"}),
        ("camera drop=0.1", Camera, {"eye"}),
        ("range drop=0.1", RangeSensor, {"nose"}),
        ("encoders drop=0.1", Encoder, {"left_encoder", "right_encoder"}),
        ("drive dead", Motor, {"left_motor", "right_motor"}),
        ("loop stall=0.1", LoopTarget, set()),
        ("connection lost=1", ConnectionTarget, EVERYTHING),
    ],
)
def test_target_is_a_device_a_role_the_loop_or_the_connection(spec: str, kind: TargetClass, devices: set[str]) -> None:
    (planned,) = plan_faults([spec], ROVER, EVERYTHING)
    assert planned.target == FaultTarget(kind, frozenset(devices))


@pytest.mark.parametrize("target, devices", [("bumper", {"front"}), ("rear", {"rear"}), ("battery", {"cells"})])
@pytest.mark.parametrize("effect", ["drop=0.1", "freeze", "delay=0.1", "lost=1", "stuck=1"])
def test_target_of_a_kind_without_a_role_is_its_first_device(target: str, devices: set[str], effect: str) -> None:
    (planned,) = plan_faults([f"{target} {effect}"], BUMPY, [device.name for device in BUMPY.devices])
    assert planned.target.devices == devices


@pytest.mark.parametrize("spec", ["bumper noise=1", "bumper bias=1", "camera stuck=1", "front weak=0.5"])
def test_effect_that_the_samples_of_a_kind_cannot_have_is_refused(spec: str) -> None:
    with pytest.raises(UsageError) as raised:
        plan_faults([spec], BUMPY, [device.name for device in BUMPY.devices])
    assert raised.value.kind == "fault-not-on-this-kind"


@pytest.mark.parametrize(
    "target, file", [("range", "sensor_values"), ("nose", "sensor_values"), ("battery", "sensor_fields")]
)
@pytest.mark.parametrize("effect", ["noise=0.1", "bias=0.1", "stuck=1", "spikes=0.1"])
def test_fault_of_the_smallest_class_is_used(target: str, file: str, effect: str) -> None:
    size = " size=1" if (effect, target) == ("spikes=0.1", "battery") else ""
    (planned,) = plan_faults([f"{target} {effect}{size}"], BUMPY, [device.name for device in BUMPY.devices])
    assert type(planned.fault).__module__.endswith(file)


def test_fault_whose_classes_are_no_tuple_is_not_loaded(register: Register, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Shift, "target_classes", {RangeSensor})
    register("shift", f"{__name__}:Shift")
    with pytest.raises(BackendMissingError):
        load_fault("shift")


@pytest.mark.parametrize(
    "spec, kind",
    [
        ("eyes drop=0.2", "unknown-target"),
        ("connection lost=2 lasts=1", "fault-parameter"),
        ("camera dorp=0.2", "unknown-effect"),
        ("camera drop=0.2 aftr=5", "fault-parameter"),
        ("camera drop=1.5", "fault-parameter"),
        ("camera drop=much", "fault-parameter"),
        ("camera drop", "fault-parameter"),
        ("camera freeze=1", "fault-parameter"),
        ("left_motor no_echo=0.2", "fault-not-on-this-kind"),
        ("loop stall=2 every=1", "fault-parameter"),
    ],
)
def test_wrong_specification_is_refused_with_the_right_form(spec: str, kind: str, raises: Raises) -> None:
    with raises(UsageError, kind, fault=str(Spec.parse(spec))):
        plan_faults([spec], ROVER, DRIVING | {"eye", "screen"})


def test_target_that_the_app_does_not_open_is_refused(raises: Raises) -> None:
    with raises(UsageError, "fault-target-not-open"):
        plan_faults(["camera drop=0.2"], ROVER, DRIVING)


class Shift(Fault):
    """Adds this to each distance.

    A wall that is not where it seems.
    """

    target_classes = (RangeSensor,)
    example = "range shift=0.1"

    value: Annotated[float, Field(ge=-1, le=1, description="metres")]
    mode: str = "plain"

    def layer(self, context: FaultContext) -> Layer:
        return Shifted(self)


class Shifted(Layer):
    def __init__(self, fault: Shift) -> None:
        self._fault = fault

    def sensor(self, sensor: Sensor[Any], read: Reader[Any]) -> Reader[Any]:
        return lambda: replace(read(), distance=read().distance + self._fault.value)


def test_another_package_can_add_an_effect_for_another_kind_of_device(register: Register) -> None:
    register("weak.range", f"{__name__}:Shift")
    rig = build_rig("nose weak=0.25", "left_motor weak=0.5")
    rig.nose.distance = 1.0
    assert rig.robot.range.read().distance == 1.25
    rig.robot.drive.set_wheels(4.0, 4.0)
    rig.commit()
    assert rig.wheels == (2.0, 4.0)


def test_code_digest_of_a_sweep_includes_a_fault_of_another_package(register: Register) -> None:
    register("shift", f"{__name__}:Shift")
    ours, without = (compute_code_digests((), (), faults) for faults in (["range drop=0.1", "range"], ()))
    assert ours == without
    assert compute_code_digests((), (), ["range shift=0.1"]) != without


def test_fault_of_another_package_is_listed(register: Register, capsys: pytest.CaptureFixture[str]) -> None:
    register("shift", f"{__name__}:Shift")
    assert execute(["faults", "--json"]) == 0
    shift = next(fault for fault in json.loads(capsys.readouterr().out) if fault["name"] == "shift")
    assert shift["on"] == ["range"]
    assert shift["summary"] == "Adds this to each distance."
    assert shift["parameters"][:1] == [{"name": "shift", "unit": "metres", "limits": "from -1 to 1", "required": True}]
    assert execute(["faults"]) == 0
    assert "shift: metres, from -1 to 1" in capsys.readouterr().out


@pytest.mark.parametrize("value", ["no_such_package:Thing", f"{__name__}:Shifted", f"{__name__}:ROVER"])
def test_fault_that_cannot_be_loaded_is_reported_and_the_others_are_listed(
    register: Register, capsys: pytest.CaptureFixture[str], value: str, raises: Raises
) -> None:
    register("broken", value)
    with pytest.raises(BackendMissingError):
        load_fault("broken")
    assert execute(["faults"]) == 0
    text = capsys.readouterr().out
    assert "broken" in text
    assert "camera drop=0.2 after=5" in text
    with raises(UsageError, "fault-not-on-this-kind"):
        plan_faults(["left_motor no_echo=1"], ROVER, {"left_motor"})


@pytest.mark.parametrize("after, lasts", [(5.0, 0.3), (0.3, 0.1), (0.1, 0.2)])
def test_fault_is_active_from_after_until_after_plus_lasts(after: float, lasts: float) -> None:
    fault = Shift(value=1.0, after=after, lasts=lasts)
    ticks = [tick for tick in range(120) if fault.is_active(tick / 20)]
    assert ticks == list(range(round(20 * after), round(20 * (after + lasts))))
