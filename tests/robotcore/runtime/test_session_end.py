from __future__ import annotations

import signal
from typing import Any

import pytest

from robotcore.errors import BackendError, BehaviourError, DeviceError, DeviceGroupError, Interrupted
from robotcore.geometry import Pose, Twist
from robotcore.hal.robot import Robot
from robotcore.hal.truth import Truth
from robotcore.runtime.behaviour import Status
from robotcore.runtime.result import Outcome
from robotcore.runtime.session import RunRequest, RunSession
from robotcore.runtime.signals import SignalGuard
from tests.robotcore.fakes import FunctionApp, RigBackend, StillTruth
from tests.robotcore.runs import Runner, drive_then
from tests.texts import CheckText


def raise_error(error: Exception) -> Any:
    raise error


AHEAD = Pose(0.0, 0.0, 0.0)


class Verifying(FunctionApp):
    """Verifies that the robot is at rest."""

    def verify(self, truth: Truth) -> bool | None:
        return truth.is_at_rest


def test_failure_to_close_turns_a_success_into_an_error(
    perform: Runner, backend: RigBackend, check_text: CheckText
) -> None:
    def unplug(robot: Robot) -> Status:
        backend.rig.left._release = lambda: raise_error(DeviceError("left_motor", "stuck"))  # type: ignore[method-assign]
        return Status.SUCCESS

    result = perform(drive_then(unplug))
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert isinstance(result.error, DeviceGroupError)
    check_text(result.reason)
    assert backend.rig.wheels == (0.0, 0.0)


def test_second_signal_does_not_interrupt_the_stopping(perform: Runner, backend: RigBackend) -> None:
    def press_again(rad_s: float) -> None:
        signal.raise_signal(signal.SIGINT)
        backend.rig.left.sent.append(rad_s)

    def press(robot: Robot) -> None:
        backend.rig.left._apply = press_again  # type: ignore[method-assign]
        signal.raise_signal(signal.SIGTERM)

    result = perform(drive_then(press))
    assert (result.outcome, result.exit_status) == (Outcome.INTERRUPTED, 143)
    assert backend.rig.wheels == (0.0, 0.0)
    assert (backend.rig.left.releases, backend.rig.right.releases) == (1, 1)


def test_late_signal_does_not_prevent_closing(
    perform: Runner, backend: RigBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    mask, last_moment = SignalGuard.mask, iter([signal.SIGTERM])

    def mask_too_late(guard: SignalGuard) -> None:
        for number in last_moment:
            signal.raise_signal(number)
        mask(guard)

    monkeypatch.setattr(SignalGuard, "mask", mask_too_late)
    result = perform(drive_then(lambda _: Status.SUCCESS))
    assert (result.outcome, result.exit_status) == (Outcome.INTERRUPTED, 143)
    assert (backend.rig.left.releases, backend.rig.right.releases) == (1, 1)


@pytest.mark.parametrize("method", ["open", "close"])
def test_signal_outside_of_the_stages_of_a_run_leaves_no_robot_open(
    perform: Runner, backend: RigBackend, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    call, moments = getattr(RunSession, method), iter([signal.SIGTERM])

    def interrupt(session: RunSession, *arguments: Any) -> Any:
        ended = call(session, *arguments) if method == "open" else None
        for number in moments:
            signal.raise_signal(number)
        return ended

    monkeypatch.setattr(RunSession, method, interrupt)
    with pytest.raises(Interrupted):
        perform(drive_then(lambda _: Status.SUCCESS))
    assert (backend.rig.left.releases, backend.rig.right.releases) == (1, 1)


def test_failure_to_open_the_robot_is_an_error_of_the_run(perform: Runner, backend: RigBackend) -> None:
    error = DeviceGroupError("opening rover", [DeviceError("eye", "no picture")])
    backend._prepare = lambda _: raise_error(error)
    result = perform(drive_then(lambda _: Status.SUCCESS))
    assert (result.outcome, result.exit_status, result.ticks, result.error) == (Outcome.ERROR, 3, 0, error)
    assert (result.trace_sha256, result.sim_time_s) == (None, 0.0)


@pytest.mark.parametrize(
    "status, twist, verified, exit_status",
    [
        (Status.SUCCESS, Twist(0.0, 0.0), True, 0),
        (Status.SUCCESS, Twist(0.2, 0.0), False, 1),
        (Status.FAILURE, Twist(0.0, 0.0), False, 1),
    ],
)
def test_success_is_verified_by_the_simulators_truth(
    perform: Runner, backend: RigBackend, status: Status, twist: Twist, verified: bool, exit_status: int
) -> None:
    backend._prepare = lambda rig: setattr(rig, "truth", StillTruth(AHEAD, twist, contacts=3))
    result = perform(Verifying(lambda _: status), RunRequest("app", world="open"))
    assert (result.outcome.value, result.verified, result.exit_status) == (status.value, verified, exit_status)
    assert (result.contacts, result.world) == (3, "open")
    assert result.distance_to_target_m is not None


def test_exception_in_verify_is_a_behaviour_error_and_the_robot_is_closed(perform: Runner, backend: RigBackend) -> None:
    backend._prepare = lambda rig: setattr(rig, "truth", StillTruth(AHEAD, contacts=2))
    app = FunctionApp(lambda _: Status.SUCCESS)
    app.verify = lambda truth: raise_error(IndexError("index"))  # type: ignore[method-assign]
    result = perform(app, RunRequest("app", world="open"))
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 5)
    assert (result.verified, result.contacts) == (None, 2)
    assert isinstance(result.error, BehaviourError)
    assert isinstance(result.error.__cause__, IndexError)
    assert (backend.rig.left.releases, backend.rig.right.releases) == (1, 1)


def test_simulator_that_died_hides_no_error(perform: Runner, backend: RigBackend) -> None:
    class Dead(StillTruth):
        def twist(self) -> Twist:
            raise BackendError("has gone")

    backend._prepare = lambda rig: setattr(rig, "truth", Dead(AHEAD))
    error = DeviceError("nose", "no echo")
    result = perform(Verifying(lambda _: raise_error(error)), RunRequest("app", world="open"))
    assert (result.error, result.verified, result.contacts) == (error, None, None)
