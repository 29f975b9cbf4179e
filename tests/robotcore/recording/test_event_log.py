"""The log of a run."""

from __future__ import annotations

from robotcore.geometry import Wheels
from robotcore.recording import Read, RecordedError, Tick
from robotcore.recording.event_log import Level, RunLog, build_last_line
from robotcore.runtime.faults import plan_faults
from robotcore.runtime.result import Outcome, RunResult
from robotcore.safety import Intervention
from tests.robotcore.fakes import ROVER
from tests.texts import CheckText

GUARD = Intervention(0.1, "range guard", Wheels(2.0, 2.0), Wheels(0.0, 0.0))


def list_lines(*ticks: Tick, milestones: tuple[str, ...] = ()) -> list[list[str]]:
    log = RunLog(milestones)
    return [[line.text for line in log.list_new(tick)] for tick in ticks]


def tick(*reads: Read, state: str = "search", interventions: tuple[Intervention, ...] = ()) -> Tick:
    return Tick(0, 0.0, state, reads=reads, interventions=interventions)


def build_failed_read(message: str) -> Read:
    return Read("eye", error=RecordedError("DeviceError", message))


def test_milestone_has_one_line(check_text: CheckText) -> None:
    lines = list_lines(tick(), tick(state="seen"), tick(state="seen"), milestones=("seen",))
    assert list(map(len, lines)) == [0, 1, 0]
    check_text(lines[1][0])


def test_injected_fault_has_a_line_at_its_begin_and_its_end(check_text: CheckText) -> None:
    faults = plan_faults(["camera drop=0.2", "camera drop=0.5 after=1 lasts=2"], ROVER, ["eye"])
    log = RunLog((), faults)
    lines = [[line.text for line in log.list_new(Tick(at, float(at), ""))] for at in range(5)]
    assert list(map(len, lines)) == [1, 1, 0, 1, 0]
    check_text("\n".join(line for each in lines for line in each))


def test_error_of_a_device_has_a_line_at_each_change(check_text: CheckText) -> None:
    good = Read("eye", 1, 0.1, 0)
    ticks = [
        tick(build_failed_read("a")),
        tick(build_failed_read("a")),
        tick(),
        tick(build_failed_read("b")),
        tick(good),
        tick(good),
    ]
    *errors, recovered, after = list_lines(*ticks)
    assert errors == [["a"], [], [], ["b"]]
    assert after == []
    check_text(*recovered)


def test_intervention_has_a_line_at_its_begin_and_its_end(check_text: CheckText) -> None:
    guarded = tick(interventions=(GUARD,))
    lines = list_lines(guarded, guarded, tick(), tick())
    assert list(map(len, lines)) == [1, 0, 1, 0]
    check_text("\n".join(line for each in lines for line in each))


def test_dropped_pictures_have_one_line() -> None:
    lost = tick(Read("eye", 1, 0.1, None))
    assert [len(lines) for lines in list_lines(tick(), lost, lost)] == [0, 1, 0]


def test_error_that_ends_a_run_has_a_line() -> None:
    ending = Tick(0, 0.0, "search", error=RecordedError("EmergencyStopError", "e-stop: pressed"))
    assert [(line.level, line.text) for line in RunLog(()).list_new(ending)] == [
        (Level.Error, "EmergencyStopError: e-stop: pressed")
    ]


def test_last_line_begins_with_the_headline() -> None:
    result = RunResult("a", "b", "c", None, None, Outcome.SUCCESS, 1, verified=False, contacts=2, ticks=3)
    assert build_last_line(result).text == "disputed, 2 contacts, 3 ticks"


def test_last_line_of_a_failed_run_is_an_error(check_text: CheckText) -> None:
    result = RunResult("a", "b", "c", None, None, Outcome.FAILURE, 1, reason="reason", ticks=3)
    line = build_last_line(result)
    assert line.level is Level.Error
    check_text(line.text)
