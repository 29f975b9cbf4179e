"""Faults of another package whose code does not work. The run ends with an error that contains the fault."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any, ClassVar

import pytest

from robotcore import Outcome, RunRequest, RunResult
from robotcore.errors import BackendError, DeviceError
from robotcore.hal.clock import Clock, ClockWrapper
from robotcore.hal.device import Device
from robotcore.runtime.faults import ConnectionTarget, Fault, FaultContext, LoopTarget, plan_faults
from robotcore.runtime.layers.base import Layer
from robotcore.runtime.session import run
from tests.robotcore.fakes import ROVER
from tests.robotcore.runtime.faults.conftest import Register, Wheels
from tests.robotcore.runtime.faults.rigs import build_rig


def _divide_by_zero(*_: object) -> None:
    raise ZeroDivisionError("division by zero")


def _return_none(*_: object) -> None:
    return None


divide_by_zero: Any = _divide_by_zero
return_none: Any = _return_none


def build_clock(clock: Clock, **methods: Any) -> Clock:
    changed = ClockWrapper(clock)
    vars(changed).update(methods)
    return changed


def build_layer(**hooks: Any) -> Layer:
    built: Layer = type("Built", (Layer,), {name: staticmethod(hook) for name, hook in hooks.items()})()
    return built


def replace_functions(function: Any) -> Layer:
    return build_layer(
        sensor=lambda _sensor, _read: function,
        motor=lambda motor: replace(motor, set_velocity=function),
        actuator=lambda _actuator, _send: function,
    )


LAYERS: dict[str, Any] = {
    "no functions": build_layer(sensor=return_none, motor=return_none),
    "failing methods": build_layer(sensor=divide_by_zero, motor=divide_by_zero),
    "texts": build_layer(sensor=lambda *_: "read", motor=lambda _: "motor"),
    "no results": replace_functions(return_none),
    "failing functions": replace_functions(divide_by_zero),
    "no layer": None,
    "no clock": build_layer(clock=return_none),
    "no time": build_layer(clock=lambda clock: build_clock(clock, now=return_none)),
    "failing sleep": build_layer(clock=lambda clock: build_clock(clock, sleep_until=divide_by_zero)),
    "forwarding clock": build_layer(clock=build_clock),
    "failing stop": build_layer(motor=lambda motor: replace(motor, stop=divide_by_zero)),
    "exiting stop": build_layer(motor=lambda motor: replace(motor, stop=lambda: sys.exit(7))),
    "forwarding": build_layer(sensor=lambda _sensor, read: lambda: read()),  # noqa: PLW0108  another function
}
"""The layers of the faults of this module."""


class Broken(Fault):
    """A fault with one of the layers."""

    target_classes = (Device, LoopTarget, ConnectionTarget)
    built: ClassVar[Any] = None

    def layer(self, context: FaultContext) -> Any:
        return LAYERS[Broken.built]

    def is_active(self, time: float) -> bool:
        raise ValueError("no schedule")


@pytest.fixture(autouse=True)
def _registered(register: Register) -> None:
    register("broken", f"{__name__}:Broken")


def search(target: str, layer: str) -> RunResult:
    Broken.built = layer
    return run(RunRequest("green-search", seed=7, timeout_s=0.5, faults=(f"{target} broken",)))


def require_error_of_the_fault(result: RunResult, kind: type[Exception], spec: str) -> None:
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert isinstance(result.error, kind)
    assert isinstance(result.error, BackendError | DeviceError)
    assert (result.error.kind, result.error.fields) == ("fault-code", {"fault": spec})


@pytest.mark.parametrize("target", ["camera", "left_motor"])
@pytest.mark.parametrize("layer", ["no functions", "texts", "failing methods", "no results", "failing functions"])
def test_fault_of_a_device_that_does_not_work_is_a_device_error(wheels: Wheels, layer: str, target: str) -> None:
    result = search(target, layer)
    require_error_of_the_fault(result, DeviceError, f"{target} broken")
    assert ("at test_checked_layer.py:" in result.reason) == layer.startswith("failing")
    assert set(wheels.values()) <= {0.0}


@pytest.mark.parametrize("layer", ["no layer", "no clock", "no time", "failing sleep"])
def test_fault_of_the_loop_that_does_not_work_is_a_backend_error(wheels: Wheels, layer: str) -> None:
    require_error_of_the_fault(search("loop", layer), BackendError, "loop broken")
    assert set(wheels.values()) <= {0.0}


@pytest.mark.parametrize("layer", ["failing stop", "exiting stop"])
@pytest.mark.parametrize("target", ["left_motor", "drive"])
def test_run_stops_every_motor_if_the_stop_of_a_fault_raises(wheels: Wheels, layer: str, target: str) -> None:
    require_error_of_the_fault(search(target, layer), DeviceError, f"{target} broken")
    assert wheels == {"left_motor": 0.0, "right_motor": 0.0}


def test_fault_of_a_display_that_does_not_work_is_a_device_error() -> None:
    Broken.built = "failing functions"
    rig = build_rig("screen broken")
    with pytest.raises(DeviceError) as raised:
        rig.robot.display.show(rig.eye.image)
    assert (raised.value.device, raised.value.kind) == ("screen", "fault-code")


def test_error_of_is_on_contains_the_fault() -> None:
    (fault,) = plan_faults(["loop broken"], ROVER, ())
    with pytest.raises(BackendError) as raised:
        fault.is_active(1.0)
    assert raised.value.kind == "fault-code"


def test_error_of_the_backend_below_a_fault_of_the_loop_does_not_contain_the_fault() -> None:
    Broken.built = "forwarding clock"
    rig = build_rig("loop broken")
    rig.clock._advance = divide_by_zero
    with pytest.raises(BackendError) as raised:
        rig.sleep(1.0)
    assert raised.value.kind == "connection-broken"


def test_error_of_a_driver_below_a_fault_does_not_contain_the_fault() -> None:
    Broken.built = "forwarding"
    rig = build_rig("nose broken")
    rig.nose._newest = divide_by_zero  # type: ignore[method-assign]
    with pytest.raises(DeviceError) as raised:
        rig.robot.range.read()
    assert (raised.value.device, raised.value.kind) == ("nose", "driver-error")
