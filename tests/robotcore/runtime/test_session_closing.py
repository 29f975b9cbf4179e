from __future__ import annotations

import signal

import pytest

from robotcore.errors import DeviceError, DeviceGroupError
from robotcore.hal.robot import Robot, Role
from robotcore.runtime.behaviour import Status
from robotcore.runtime.result import Outcome
from robotcore.runtime.signals import Interrupts
from tests.robotcore.fakes import Rig, RigBackend
from tests.robotcore.runs import Runner, then


def test_a_device_that_fails_to_close_makes_a_success_an_error(perform: Runner, backend: RigBackend) -> None:
    def unplug(robot: Robot) -> Status:
        backend.rig.eye.close = _fail_to_close  # type: ignore[method-assign]
        return Status.SUCCESS

    app = then(unplug)
    app.needs = frozenset({Role.DRIVE, Role.CAMERA})  # type: ignore[misc]
    result = perform(app)
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert isinstance(result.error, DeviceGroupError)
    assert "eye: stuck" in result.reason
    assert backend.rig.wheels == (0.0, 0.0)


def test_a_motor_that_breaks_keeps_the_other_from_nothing_and_the_first_error_stands(
    perform: Runner, backend: RigBackend
) -> None:
    def cut(robot: Robot) -> None:
        backend.rig.left.is_broken = True

    result = perform(then(cut))
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert result.reason.startswith("left_motor: no current; closing rig: 1 device(s) failed")
    assert backend.rig.right.sent[-1] == 0.0


def test_a_second_signal_cuts_the_stopping_short_of_nothing(perform: Runner, backend: RigBackend) -> None:
    def press_again(rad_s: float) -> None:
        signal.raise_signal(signal.SIGINT)
        backend.rig.left.sent.append(rad_s)

    def press(robot: Robot) -> None:
        backend.rig.left._apply = press_again  # type: ignore[method-assign]
        signal.raise_signal(signal.SIGTERM)

    result = perform(then(press))
    assert (result.outcome, result.exit_status) == (Outcome.INTERRUPTED, 143)
    assert backend.rig.wheels == (0.0, 0.0)
    assert (backend.rig.left.releases, backend.rig.right.releases) == (1, 1)


def test_a_signal_in_the_last_moment_keeps_nothing_from_being_closed(
    perform: Runner, backend: RigBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    hold, last_moment = Interrupts.hold, iter([signal.SIGTERM])

    def hold_too_late(interrupts: Interrupts) -> None:
        for number in last_moment:
            signal.raise_signal(number)
        hold(interrupts)

    monkeypatch.setattr(Interrupts, "hold", hold_too_late)
    result = perform(then(lambda _: Status.SUCCESS))
    assert (result.outcome, result.exit_status) == (Outcome.INTERRUPTED, 143)
    assert (backend.rig.left.releases, backend.rig.right.releases) == (1, 1)


def test_a_robot_that_cannot_be_opened_is_an_error_of_the_run(perform: Runner, backend: RigBackend) -> None:
    def fail(rig: Rig) -> None:
        raise DeviceGroupError("opening rover", [DeviceError("eye", "no picture")])

    backend._prepare = fail
    result = perform(then(lambda _: Status.SUCCESS))
    assert (result.outcome, result.exit_status, result.ticks) == (Outcome.ERROR, 3, 0)
    assert (result.trace_sha256, result.sim_time_s) == (None, 0.0)
    assert "eye: no picture" in result.reason


def _fail_to_close() -> None:
    raise DeviceError("eye", "stuck")
