"""test_log."""

from __future__ import annotations

from robotcore.geometry import Wheels
from robotcore.recording import Read, RecordedError, Tick
from robotcore.recording.log import Level, RunLog, build_last_line
from robotcore.runtime.faults import plan_faults
from robotcore.runtime.result import Outcome, RunResult
from robotcore.safety import Intervention
from tests.robotcore.fakes import ROVER

GUARD = Intervention(0.1, "range guard", Wheels(2.0, 2.0), Wheels(0.0, 0.0))


def log_lines(*ticks: Tick, milestones: tuple[str, ...] = ()) -> list[list[str]]:
    log = RunLog(milestones)
    return [[line.text for line in log.list_new(tick)] for tick in ticks]


def tick(*reads: Read, state: str = "search", interventions: tuple[Intervention, ...] = ()) -> Tick:
    return Tick(0, 0.0, state, reads=reads, interventions=interventions)


def failed(message: str) -> Read:
    return Read("eye", error=RecordedError("DeviceError", message))


def test_a_milestone_is_reported_once() -> None:
    lines = log_lines(tick(), tick(state="seen"), tick(state="seen"), milestones=("seen",))
    assert lines == [[], ["milestone: seen"], []]


def test_a_fault_on_purpose_is_reported_when_it_begins_and_when_it_ends() -> None:
    faults = plan_faults(["camera drop=0.2", "camera drop=0.5 after=1 lasts=2"], ROVER, ["eye"])
    log = RunLog((), faults)
    lines = [[line.text for line in log.list_new(Tick(at, float(at), ""))] for at in range(5)]
    begins, ends = (f"fault {what}: camera drop=0.5 after=1 lasts=2" for what in ("begins", "ends"))
    assert lines == [["fault begins: camera drop=0.2"], [begins], [], [ends], []]


def test_a_device_s_fault_is_reported_when_it_comes_when_it_changes_and_when_it_goes() -> None:
    good = Read("eye", 1, 0.1, 0)
    ticks = [tick(failed("a")), tick(failed("a")), tick(), tick(failed("b")), tick(good), tick(good)]
    assert log_lines(*ticks) == [["a"], [], [], ["b"], ["eye: gives samples again"], []]


def test_what_the_safety_stage_does_is_reported_when_it_begins_and_when_it_lets_go() -> None:
    guarded = tick(interventions=(GUARD,))
    begins = "range guard: (2.00, 2.00) rad/s became (0.00, 0.00) rad/s"
    assert log_lines(guarded, guarded, tick(), tick()) == [[begins], [], ["range guard: lets go"], []]


def test_dropped_pictures_are_reported_once() -> None:
    lost = tick(Read("eye", 1, 0.1, None))
    assert [len(lines) for lines in log_lines(tick(), lost, lost)] == [0, 1, 0]


def test_what_ends_a_run_is_reported_as_an_error() -> None:
    ending = Tick(0, 0.0, "search", error=RecordedError("EmergencyStopError", "e-stop: pressed"))
    assert [(line.level, line.text) for line in RunLog(()).list_new(ending)] == [
        (Level.Error, "EmergencyStopError: e-stop: pressed")
    ]


def test_the_last_line_worries_where_the_run_does_not_exit_with_zero() -> None:
    result = RunResult("a", "b", "c", None, None, Outcome.FAILURE, 1, reason="no ball", ticks=3)
    assert build_last_line(result) == (Level.Error, "failure, 3 ticks: no ball")
