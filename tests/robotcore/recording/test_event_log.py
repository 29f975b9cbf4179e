"""The log of a run."""

from __future__ import annotations

import pytest

from robotcore.geometry import Wheels
from robotcore.recording import Read, RecordedError, Tick
from robotcore.recording.event_log import Level, RunLog, build_last_line
from robotcore.runtime.faults import plan_faults
from robotcore.runtime.result import Outcome, RunResult
from robotcore.safety.velocity_limits import Intervention
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


def test_lasting_events_have_a_line_at_their_begin_and_their_end(check_text: CheckText) -> None:
    guarded, lost = tick(interventions=(GUARD,)), tick(Read("eye", 1, 0.1, None))
    ended = Tick(0, 0.0, "seen", error=RecordedError("EmergencyStopError", "e-stop: pressed"))
    ticks = (tick(), tick(state="seen"), guarded, guarded, tick(), tick(), lost, lost, ended, ended, tick())
    lines = list_lines(*ticks, milestones=("seen",))
    assert list(map(len, lines)) == [0, 1, 1, 0, 1, 0, 1, 0, 1, 0, 1]
    check_text("\n".join(line for each in lines for line in each))


@pytest.mark.parametrize("outcome, level", [(Outcome.FAILURE, Level.Error), (Outcome.SUCCESS, Level.Info)])
def test_last_line_has_the_headline_and_the_reason(outcome: Outcome, level: Level, check_text: CheckText) -> None:
    status = int(outcome is Outcome.FAILURE)
    line = build_last_line(RunResult("a", "b", "c", None, None, outcome, status, reason="reason", contacts=2, ticks=3))
    assert line.level is level
    check_text(line.text)
