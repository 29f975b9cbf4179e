from __future__ import annotations

import json

import pytest

from robotcore.errors import BackendError, DeviceError
from robotcore.geometry import Pose, Twist
from robotcore.hal.truth import Truth
from robotcore.runtime.behaviour import Status
from robotcore.runtime.result import Outcome
from robotcore.runtime.session import RunRequest
from tests.robotcore.fakes import Deed, RigBackend, StillTruth
from tests.robotcore.runs import Runner, then

AHEAD = Pose(0.0, 0.0, 0.0)


class Verifying(Deed):
    """Judges by whether the truth is at rest."""

    def verify(self, truth: Truth) -> bool | None:
        return truth.is_at_rest


class Confused(Deed):
    def verify(self, truth: Truth) -> bool | None:
        raise IndexError("no such witness")


@pytest.mark.parametrize(
    "status, twist, verified, exit_status",
    [
        (Status.SUCCESS, Twist(0.0, 0.0), True, 0),
        (Status.SUCCESS, Twist(0.2, 0.0), False, 1),
        (Status.FAILURE, Twist(0.0, 0.0), False, 1),
    ],
)
def test_a_success_is_verified_by_what_the_simulator_knows(
    perform: Runner, backend: RigBackend, status: Status, twist: Twist, verified: bool, exit_status: int
) -> None:
    backend._prepare = lambda rig: setattr(rig, "truth", StillTruth(AHEAD, twist, contacts=3))
    result = perform(Verifying(lambda _: status), RunRequest("app", world="open"))
    assert (result.outcome.value, result.verified, result.exit_status) == (status.value, verified, exit_status)
    assert (result.contacts, result.world) == (3, "open")
    assert result.distance_to_target_m is not None


def test_nobody_judges_an_app_that_says_nothing_of_the_truth(perform: Runner, backend: RigBackend) -> None:
    backend._prepare = lambda rig: setattr(rig, "truth", StillTruth(AHEAD))
    result = perform(then(lambda _: Status.SUCCESS), RunRequest("app", world="open"))
    assert (result.verified, result.contacts) == (None, 0)


def test_what_a_real_robot_cannot_know_is_null(perform: Runner) -> None:
    told = json.loads(perform(Verifying(lambda _: Status.SUCCESS)).to_json())
    assert (told["verified"], told["contacts"], told["distance_to_target_m"]) == (None, None, None)


def test_a_judge_that_raises_is_the_apps_fault_and_the_robot_is_closed(perform: Runner, backend: RigBackend) -> None:
    backend._prepare = lambda rig: setattr(rig, "truth", StillTruth(AHEAD, contacts=2))
    result = perform(Confused(lambda _: Status.SUCCESS), RunRequest("app", world="open"))
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 5)
    assert (result.verified, result.contacts) == (None, 2)
    assert result.reason == "Confused raised IndexError: no such witness"
    assert result.error
    assert isinstance(result.error.__cause__, IndexError)
    assert (backend.rig.left.releases, backend.rig.right.releases) == (1, 1)


def test_a_simulator_that_has_died_has_no_word_and_hides_no_error(perform: Runner, backend: RigBackend) -> None:
    class Dead(StillTruth):
        def twist(self) -> Twist:
            raise BackendError("has gone")

    backend._prepare = lambda rig: setattr(rig, "truth", Dead(AHEAD))
    error = DeviceError("nose", "no echo")
    result = perform(Verifying(lambda _: raise_(error)), RunRequest("app", world="open"))
    assert (result.error, result.verified, result.contacts) == (error, None, None)


def raise_(error: Exception) -> Status:
    raise error
