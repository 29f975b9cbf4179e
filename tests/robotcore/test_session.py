from __future__ import annotations

import json
import signal
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest

from robotcore import session
from robotcore.behaviour import Behaviour, Status
from robotcore.clock import Clock, PacedClock
from robotcore.errors import (
    BackendError,
    BehaviourError,
    DeviceError,
    DeviceGroupError,
    Interrupted,
    InvalidCommandError,
    StaleSampleError,
    UnmetNeedError,
    UsageError,
)
from robotcore.geometry import Pose, Twist
from robotcore.interrupts import Interrupts
from robotcore.outcome import Outcome
from robotcore.robot import Robot, Role
from robotcore.session import Run, RunRequest, RunResult, run
from robotcore.trace import TickRecord
from robotcore.truth import Truth
from tests.robotcore.fakes import Deed, Rig, RigBackend, StillTruth

AHEAD = Pose(0.0, 0.0, 0.0)
Runner = Callable[..., RunResult]


class Watcher:
    """An observer that keeps what it hears, by name."""

    def __init__(self) -> None:
        self.heard: list[tuple[str, Any]] = []

    def begin(self, run: Run) -> None:
        self.heard.append(("begin", run))

    def tick(self, record: TickRecord) -> None:
        self.heard.append(("tick", record))

    def end(self, result: RunResult) -> None:
        self.heard.append(("end", result))


@pytest.fixture
def backend() -> RigBackend:
    return RigBackend()


@pytest.fixture
def perform(backend: RigBackend, monkeypatch: pytest.MonkeyPatch) -> Runner:
    """Run an app that is given on null devices."""

    def perform(app: Behaviour, request: RunRequest | None = None, **parts: Any) -> RunResult:
        monkeypatch.setattr("robotcore.plan.load_backend", lambda _: backend)
        monkeypatch.setattr("robotcore.plan.load_app", type)
        monkeypatch.setattr("robotcore.plan.configure", lambda *_: app)
        return run(request or RunRequest("an_app"), **parts)

    return perform


def driving(robot: Robot, left: float = 2.0) -> None:
    robot.drive.set_wheels(left, 2.0)


def then(end: Callable[[Robot], object]) -> Deed:
    """Return an app that drives for two ticks and then does what is given."""
    ticks: list[int] = []

    def deed(robot: Robot) -> Status:
        ticks.append(1)
        driving(robot)
        if len(ticks) < 3:
            return Status.RUNNING
        said = end(robot)
        return said if isinstance(said, Status) else Status.RUNNING

    return Deed(deed)


def raising(error: BaseException) -> Deed:
    def deed(robot: Robot) -> None:
        raise error

    return then(deed)


class TestEnd:
    @pytest.mark.parametrize(
        "status, outcome, exit_status",
        [(Status.SUCCESS, Outcome.SUCCESS, 0), (Status.FAILURE, Outcome.FAILURE, 1)],
    )
    def test_what_the_app_says(
        self, perform: Runner, backend: RigBackend, status: Status, outcome: Outcome, exit_status: int
    ) -> None:
        result = perform(then(lambda _: status))
        assert (result.outcome, result.exit_status, result.ticks) == (outcome, exit_status, 3)
        assert result.error is None
        assert backend.rig.wheels == (0.0, 0.0)

    def test_a_timeout_is_a_failure_that_says_where_the_app_was(self, perform: Runner) -> None:
        result = perform(then(lambda _: None), RunRequest("app", timeout_s=0.5))
        assert (result.outcome, result.exit_status) == (Outcome.TIMEOUT, 1)
        assert result.reason == "not done after 0.5 s, in 'start'"
        assert (result.sim_time_s, result.ticks) == (0.5, 11)

    @pytest.mark.parametrize(
        "error, outcome, exit_status",
        [
            (BackendError("the simulator has gone"), Outcome.ERROR, 3),
            (DeviceError("eye", "no picture"), Outcome.ERROR, 3),
            (InvalidCommandError("nan"), Outcome.STOPPED, 4),
            (StaleSampleError("nose", 2.0, 1.0), Outcome.STOPPED, 4),
            (BehaviourError("lost"), Outcome.ERROR, 5),
            (Interrupted(signal.SIGINT), Outcome.INTERRUPTED, 130),
            (Interrupted(signal.SIGTERM), Outcome.INTERRUPTED, 143),
        ],
        ids=lambda value: type(value).__name__,
    )
    def test_an_error_has_its_outcome_and_status_and_stops_every_motor(
        self, perform: Runner, backend: RigBackend, error: BaseException, outcome: Outcome, exit_status: int
    ) -> None:
        result = perform(raising(error))
        assert (result.outcome, result.exit_status) == (outcome, exit_status)
        assert result.error is error
        assert result.reason == str(error)
        assert backend.rig.wheels == (0.0, 0.0)
        assert (backend.rig.left.releases, backend.rig.right.releases) == (1, 1)

    def test_what_the_app_raises_is_kept_with_its_cause(self, perform: Runner, backend: RigBackend) -> None:
        result = perform(raising(KeyError("left")))
        assert (result.outcome, result.exit_status) == (Outcome.ERROR, 5)
        assert result.error
        assert isinstance(result.error.__cause__, KeyError)
        assert backend.rig.wheels == (0.0, 0.0)

    def test_a_velocity_that_is_no_number_is_a_safety_stop(self, perform: Runner, backend: RigBackend) -> None:
        result = perform(then(lambda robot: driving(robot, float("nan"))))
        assert (result.outcome, result.exit_status) == (Outcome.STOPPED, 4)
        assert backend.rig.wheels == (0.0, 0.0)

    @pytest.mark.parametrize("error", [SystemExit(0), UsageError("no such corner"), UnmetNeedError("no arm")])
    def test_an_app_that_gives_up_in_its_own_way_has_raised(
        self, perform: Runner, backend: RigBackend, error: BaseException
    ) -> None:
        result = perform(raising(error))
        assert (result.outcome, result.exit_status) == (Outcome.ERROR, 5)
        assert backend.rig.wheels == (0.0, 0.0)
        assert backend.rig.left.releases == 1

    def test_a_velocity_that_is_no_number_ends_the_run_though_the_app_swallows_it(self, perform: Runner) -> None:
        def swallow(robot: Robot) -> Status:
            with suppress(Exception):
                driving(robot, float("nan"))
            return Status.RUNNING

        result = perform(then(swallow))
        assert (result.outcome, result.exit_status) == (Outcome.STOPPED, 4)

    def test_a_driver_that_raises_what_it_did_not_translate_has_failed(
        self, perform: Runner, backend: RigBackend
    ) -> None:
        def unplug(robot: Robot) -> Status:
            backend.rig.nose._newest = _reset  # type: ignore[method-assign]
            robot.range.read()
            return Status.RUNNING

        result = perform(then(unplug))
        assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
        assert result.reason == "nose: ConnectionResetError: gone"

    def test_an_apps_reason_is_told(self, perform: Runner) -> None:
        app = then(lambda _: Status.FAILURE)
        app.reason = "no ball"
        assert perform(app).reason == "no ball"


class TestClosing:
    def test_a_device_that_fails_to_close_makes_a_success_an_error(self, perform: Runner, backend: RigBackend) -> None:
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
        self, perform: Runner, backend: RigBackend
    ) -> None:
        def cut(robot: Robot) -> None:
            backend.rig.left.is_broken = True

        result = perform(then(cut))
        assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
        assert result.reason.startswith("left_motor: no current; closing rig: 1 device(s) failed")
        assert backend.rig.right.sent[-1] == 0.0

    def test_a_second_signal_cuts_the_stopping_short_of_nothing(self, perform: Runner, backend: RigBackend) -> None:
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
        self, perform: Runner, backend: RigBackend, monkeypatch: pytest.MonkeyPatch
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

    def test_a_robot_that_cannot_be_opened_is_an_error_of_the_run(self, perform: Runner, backend: RigBackend) -> None:
        def fail(rig: Rig) -> None:
            raise DeviceGroupError("opening rover", [DeviceError("eye", "no picture")])

        backend._prepare = fail
        result = perform(then(lambda _: Status.SUCCESS))
        assert (result.outcome, result.exit_status, result.ticks) == (Outcome.ERROR, 3, 0)
        assert (result.trace_sha256, result.sim_time_s) == (None, 0.0)
        assert "eye: no picture" in result.reason


class TestOpening:
    @pytest.mark.parametrize(
        "needs, wants, opened",
        [
            ({Role.CAMERA}, (), {"eye"}),
            ({Role.RANGE}, {Role.DISPLAY}, {"nose", "screen"}),
            ({Role.DRIVE}, (), {"left_motor", "right_motor", "left_encoder", "right_encoder", "nose"}),
        ],
    )
    def test_only_what_the_app_needs_and_wants_is_opened(
        self, perform: Runner, backend: RigBackend, needs: set[Role], wants: set[Role], opened: set[str]
    ) -> None:
        app = Deed(lambda _: Status.SUCCESS)
        app.needs, app.wants = frozenset(needs), frozenset(wants)  # type: ignore[misc]
        perform(app)
        assert backend.rig.names == opened

    def test_a_need_that_cannot_be_met_is_refused_before_anything_is_opened(
        self, perform: Runner, backend: RigBackend
    ) -> None:
        with pytest.raises(UnmetNeedError):
            perform(then(lambda _: Status.SUCCESS), RunRequest("app", robot="lookout"))
        assert backend.rigs == []

    def test_simulated_time_is_held_to_real_time_only_where_it_is_asked_for(
        self, perform: Runner, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        paced: list[Clock] = []

        class Noting(PacedClock):
            def __init__(self, source: Clock) -> None:
                super().__init__(source)
                paced.append(source)

        monkeypatch.setattr(session, "PacedClock", Noting)
        perform(then(lambda _: Status.SUCCESS))
        assert paced == []
        perform(then(lambda _: Status.SUCCESS), RunRequest("app", realtime=True))
        assert len(paced) == 1


class Verifying(Deed):
    """Judges by whether the truth is at rest."""

    def verify(self, truth: Truth) -> bool | None:
        return truth.is_at_rest


class Confused(Deed):
    def verify(self, truth: Truth) -> bool | None:
        raise IndexError("no such witness")


class TestTruth:
    @pytest.mark.parametrize(
        "status, twist, verified",
        [
            (Status.SUCCESS, Twist(0.0, 0.0), True),
            (Status.SUCCESS, Twist(0.2, 0.0), False),
            (Status.FAILURE, Twist(0.0, 0.0), False),
        ],
    )
    def test_a_success_is_verified_by_what_the_simulator_knows(
        self, perform: Runner, backend: RigBackend, status: Status, twist: Twist, verified: bool
    ) -> None:
        backend._prepare = lambda rig: setattr(rig, "truth", StillTruth(AHEAD, twist, contacts=3))
        result = perform(Verifying(lambda _: status), RunRequest("app", world="open"))
        assert (result.verified, result.contacts, result.world) == (verified, 3, "open")
        assert result.distance_to_target_m is not None

    def test_nobody_judges_an_app_that_says_nothing_of_the_truth(self, perform: Runner, backend: RigBackend) -> None:
        backend._prepare = lambda rig: setattr(rig, "truth", StillTruth(AHEAD))
        result = perform(then(lambda _: Status.SUCCESS), RunRequest("app", world="open"))
        assert (result.verified, result.contacts) == (None, 0)

    def test_what_a_real_robot_cannot_know_is_null(self, perform: Runner) -> None:
        told = json.loads(perform(Verifying(lambda _: Status.SUCCESS)).to_json())
        assert (told["verified"], told["contacts"], told["distance_to_target_m"]) == (None, None, None)

    def test_a_judge_that_raises_is_the_apps_fault_and_the_robot_is_closed(
        self, perform: Runner, backend: RigBackend
    ) -> None:
        backend._prepare = lambda rig: setattr(rig, "truth", StillTruth(AHEAD))
        result = perform(Confused(lambda _: Status.SUCCESS), RunRequest("app", world="open"))
        assert (result.outcome, result.exit_status) == (Outcome.ERROR, 5)
        assert result.reason == "Confused raised IndexError: no such witness"
        assert result.error
        assert isinstance(result.error.__cause__, IndexError)
        assert (backend.rig.left.releases, backend.rig.right.releases) == (1, 1)

    def test_a_simulator_that_has_died_has_no_word_and_hides_no_error(
        self, perform: Runner, backend: RigBackend
    ) -> None:
        class Dead(StillTruth):
            def twist(self) -> Twist:
                raise BackendError("has gone")

        backend._prepare = lambda rig: setattr(rig, "truth", Dead(AHEAD))
        error = DeviceError("nose", "no echo")
        result = perform(Verifying(lambda _: raise_(error)), RunRequest("app", world="open"))
        assert (result.error, result.verified, result.contacts) == (error, None, None)


class TestTelling:
    def test_observers_hear_the_run_each_tick_and_the_result(self, perform: Runner) -> None:
        watcher = Watcher()
        result = perform(then(lambda _: Status.SUCCESS), observers=[watcher])
        assert [name for name, _ in watcher.heard] == ["begin", "tick", "tick", "tick", "end"]
        assert watcher.heard[-1][1] is result
        assert [record.tick for name, record in watcher.heard if name == "tick"] == [0, 1, 2]

    def test_the_end_is_told_even_where_the_run_failed(self, perform: Runner) -> None:
        watcher = Watcher()
        perform(raising(DeviceError("eye", "no picture")), observers=[watcher])
        assert watcher.heard[-1][0] == "end"

    def test_names_and_numbers_of_the_request_are_in_the_result(self, perform: Runner) -> None:
        result = perform(then(lambda _: Status.SUCCESS), RunRequest("an_app", seed=4))
        assert (result.app, result.backend, result.robot, result.world, result.seed) == (
            "an-app",
            "rig",
            "rover",
            None,
            4,
        )

    def test_milestones_interventions_and_digest_are_those_of_the_trace(
        self, perform: Runner, backend: RigBackend
    ) -> None:
        app = then(lambda _: Status.SUCCESS)
        app.milestones = ("start", "never")  # type: ignore[misc]
        backend._prepare = lambda rig: setattr(rig.nose, "distance", 0.05)
        first, second = perform(app), perform(then(lambda _: Status.SUCCESS))
        assert (first.milestones, first.interventions) == ({"start": 0.0}, 3)
        assert first.trace_sha256 == second.trace_sha256

    def test_the_line_of_json_tells_everything_but_the_exception(self, perform: Runner) -> None:
        told = json.loads(perform(raising(DeviceError("eye", "no picture"))).to_json())
        assert told["outcome"] == "error"
        assert "error" not in told
        assert set(told) == set(RunResult.__dataclass_fields__) - {"error"}


def raise_(error: Exception) -> Status:
    raise error


def _fail_to_close() -> None:
    raise DeviceError("eye", "stuck")


def _reset() -> Any:
    raise ConnectionResetError("gone")
