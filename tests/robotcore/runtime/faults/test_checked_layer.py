"""Faults of another package whose code does not work. The run ends with an error that contains the fault."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from typing import Any, ClassVar

import pytest

from robotcore import Outcome, RunRequest, RunResult
from robotcore.errors import BackendError, DeviceError
from robotcore.hal.clock import Clock, ClockWrapper
from robotcore.hal.devices import Display, Sensor
from robotcore.runtime.faults import Fault, FaultContext, TargetKind, plan_faults
from robotcore.runtime.layers.base import Layer, MotorOutput, Reader, Show
from robotcore.runtime.session import run
from tests.robotcore.fakes import ROVER
from tests.robotcore.runtime.faults.conftest import Register, Wheels
from tests.robotcore.runtime.faults.rigs import build_rig
from tests.texts import CheckText


class NoLayer(Fault):
    """Its method ``layer`` returns ``built``."""

    on = frozenset(TargetKind)
    built: ClassVar[Any] = None

    def layer(self, context: FaultContext) -> Any:
        return type(self).built


class FailingFault(NoLayer):
    def layer(self, context: FaultContext) -> Layer:
        raise ValueError("no grid")

    def is_on(self, time: float) -> bool:
        raise ValueError("no schedule")


def _divide_by_zero(*_: object) -> None:
    raise ZeroDivisionError("division by zero")


def _return_none(*_: object) -> None:
    return None


divide_by_zero: Any = _divide_by_zero
return_none: Any = _return_none


class NoFunctions(NoLayer):
    """The methods of its layer return None."""

    class Built(Layer):
        sensor = motor = return_none

    built = Built()


class FailingMethods(NoLayer):
    """The methods of its layer raise an exception."""

    class Built(Layer):
        sensor = motor = divide_by_zero

    built = Built()


class ReplacedFunctions(Layer):
    """Replaces the functions of a device by one other function."""

    def __init__(self, function: Any) -> None:
        self._function = function

    def sensor(self, sensor: Sensor[Any], read: Reader[Any]) -> Any:
        return self._function

    def motor(self, motor: MotorOutput) -> MotorOutput:
        return replace(motor, set_velocity=self._function)

    def display(self, display: Display, show: Show) -> Any:
        return self._function


class NoResults(NoLayer):
    built = ReplacedFunctions(return_none)


class FailingFunctions(NoLayer):
    built = ReplacedFunctions(divide_by_zero)


class NoClock(NoLayer):
    class Built(Layer):
        clock = return_none

    built = Built()


class FailingClockMethod(NoLayer):
    class Built(Layer):
        clock = divide_by_zero

    built = Built()


class NoTime(NoLayer):
    class Built(Layer):
        def clock(self, clock: Clock) -> Clock:
            changed = ClockWrapper(clock)
            changed.now = return_none  # type: ignore[method-assign]
            return changed

    built = Built()


class FailingSleep(NoLayer):
    class Built(Layer):
        def clock(self, clock: Clock) -> Clock:
            changed = ClockWrapper(clock)
            changed.sleep_until = divide_by_zero  # type: ignore[method-assign]
            return changed

    built = Built()


class FailingStop(NoLayer):
    class Built(Layer):
        def motor(self, motor: MotorOutput) -> MotorOutput:
            return replace(motor, stop=divide_by_zero)

    built = Built()


class ExitingStop(NoLayer):
    class Built(Layer):
        def motor(self, motor: MotorOutput) -> MotorOutput:
            return replace(motor, stop=lambda: sys.exit(7))

    built = Built()


class Forwarding(NoLayer):
    """Its layer replaces each function and the clock by one that forwards each call."""

    class Built(Layer):
        def sensor(self, sensor: Sensor[Any], read: Reader[Any]) -> Any:
            def forward() -> Any:
                return read()

            return forward

        def clock(self, clock: Clock) -> Clock:
            return ClockWrapper(clock)

    built = Built()


def register_as_broken(register: Register, fault: type[Fault]) -> None:
    register("broken", f"{__name__}:{fault.__name__}")


def search(spec: str) -> RunResult:
    return run(RunRequest("green-search", seed=7, timeout_s=0.5, faults=(spec,)))


def without_lines(text: object) -> str:
    return re.sub(r"\.py:\d+", ".py:LINE", str(text))


def require_error_of_the_fault(result: RunResult, kind: type[Exception], spec: str) -> None:
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert isinstance(result.error, kind)
    assert isinstance(result.error, BackendError | DeviceError)
    assert (result.error.kind, result.error.fields) == ("fault-code", {"fault": spec})


@pytest.mark.parametrize("target", ["camera", "range", "left_encoder", "left_motor"])
@pytest.mark.parametrize("fault", [NoFunctions, NoResults, FailingMethods, FailingFunctions])
def test_fault_of_a_device_that_does_not_work_is_a_device_error(
    register: Register, wheels: Wheels, check_text: CheckText, fault: type[Fault], target: str
) -> None:
    register_as_broken(register, fault)
    result = search(f"{target} broken")
    require_error_of_the_fault(result, DeviceError, f"{target} broken")
    assert set(wheels.values()) <= {0.0}
    check_text(without_lines(result.reason))


@pytest.mark.parametrize("fault", [NoLayer, FailingFault, NoClock, FailingClockMethod, NoTime, FailingSleep])
def test_fault_of_the_loop_that_does_not_work_is_a_backend_error(
    register: Register, wheels: Wheels, check_text: CheckText, fault: type[Fault]
) -> None:
    register_as_broken(register, fault)
    result = search("loop broken")
    require_error_of_the_fault(result, BackendError, "loop broken")
    assert set(wheels.values()) <= {0.0}
    check_text(without_lines(result.reason))


@pytest.mark.parametrize("fault", [FailingStop, ExitingStop])
@pytest.mark.parametrize("target", ["left_motor", "drive"])
def test_run_stops_every_motor_if_the_stop_of_a_fault_raises(
    register: Register, wheels: Wheels, check_text: CheckText, fault: type[Fault], target: str
) -> None:
    register_as_broken(register, fault)
    result = search(f"{target} broken")
    require_error_of_the_fault(result, DeviceError, f"{target} broken")
    assert wheels == {"left_motor": 0.0, "right_motor": 0.0}
    check_text(without_lines(result.reason))


def test_driver_stops_the_motor_before_the_error_of_the_stop_is_raised(register: Register) -> None:
    register_as_broken(register, FailingStop)
    rig = build_rig("left_motor broken")
    rig.robot.drive.set_velocity(0.2, 0.0)
    rig.commit()
    with pytest.raises(DeviceError):
        rig.robot.drive.stop()
    assert rig.wheels == (0.0, 0.0)


def test_fault_of_a_display_that_does_not_work_is_a_device_error(register: Register) -> None:
    register_as_broken(register, FailingFunctions)
    rig = build_rig("screen broken")
    with pytest.raises(DeviceError) as raised:
        rig.robot.display.show(rig.eye.image)
    assert (raised.value.device, raised.value.kind) == ("screen", "fault-code")


def test_error_of_is_on_contains_the_fault(register: Register, check_text: CheckText) -> None:
    register_as_broken(register, FailingFault)
    (fault,) = plan_faults(["loop broken"], ROVER, ())
    with pytest.raises(BackendError) as raised:
        fault.is_on(1.0)
    check_text(without_lines(raised.value))


def test_error_of_a_driver_below_a_fault_does_not_contain_the_fault(register: Register) -> None:
    register_as_broken(register, Forwarding)
    rig = build_rig("nose broken")
    rig.nose._newest = divide_by_zero  # type: ignore[method-assign]
    with pytest.raises(DeviceError) as raised:
        rig.robot.range.read()
    assert (raised.value.device, raised.value.kind) == ("nose", "driver-error")


def test_exception_of_a_callback_below_a_fault_is_raised_unchanged(register: Register) -> None:
    register_as_broken(register, Forwarding)
    rig = build_rig("loop broken")
    rig.clock.call_at(0.1, divide_by_zero)
    with pytest.raises(ZeroDivisionError):
        rig.sleep(0.2)
