from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from robotcore.errors import GuardianError
from robotcore.hal.cutoff import CutoffSpec
from robotcore.safety.guardian import client
from robotcore.safety.guardian.client import Guardian
from robotcore.safety.guardian.protocol import Report
from tests.robotcore.safety.guardian.doubles import cutoff
from tests.robotcore.safety.guardian.recorder import notes

LEASE_S = 0.2


@pytest.fixture
def diary(tmp_path: Path) -> Path:
    return tmp_path / "diary"


def deeds(diary: Path) -> list[str]:
    return [note.what for note in notes(diary)]


def stopped(guarding: Guardian) -> Iterator[Report]:
    while True:
        yield from guarding.stops()


def test_it_stops_what_is_not_commanded_any_more(diary: Path) -> None:
    with Guardian([cutoff(diary)], LEASE_S) as guarding:
        guarding.renew_lease()
        assert next(stopped(guarding)) == Report("stop", ("left_motor",), ())
    assert deeds(diary) == ["open left_motor", "arm left_motor", "stop left_motor", "close left_motor"]


def test_a_command_right_after_a_rest_is_guarded(diary: Path) -> None:
    with Guardian([cutoff(diary)], LEASE_S) as guarding:
        guarding.renew_lease()
        guarding.end_lease()
        guarding.renew_lease()
        assert next(stopped(guarding)).done == ("left_motor",)


def test_a_cutoff_that_hangs_holds_up_no_other(diary: Path) -> None:
    cutoffs = [cutoff(diary, "stuck", "hangs in stop"), cutoff(diary, "left_motor"), cutoff(diary, "right_motor")]
    with Guardian(cutoffs, LEASE_S) as guarding:
        guarding.renew_lease()
        with pytest.raises(GuardianError, match="could not stop stuck: does not answer"):
            next(stopped(guarding))
        assert {"stop left_motor", "stop right_motor"} <= set(deeds(diary))


def test_a_stop_that_fails_at_first_is_tried_again(diary: Path) -> None:
    with Guardian([cutoff(diary, manner="late")], LEASE_S) as guarding:
        guarding.renew_lease()
        assert next(stopped(guarding)).done == ("left_motor",)


def test_a_cutoff_that_cannot_be_armed_is_reported(diary: Path) -> None:
    with Guardian([cutoff(diary, manner="fails to arm")], LEASE_S) as guarding:
        guarding.renew_lease()
        with pytest.raises(GuardianError, match="could not arm left_motor: OSError: no arm"):
            next(stopped(guarding))


def test_a_cutoff_that_is_patient_may_be_slow_to_arm(diary: Path) -> None:
    slow = cutoff(diary, manner="is slow to arm")
    with Guardian([slow], LEASE_S) as guarding:
        guarding.renew_lease()
        with pytest.raises(GuardianError, match="could not arm left_motor: does not answer"):
            next(stopped(guarding))
    with Guardian([replace(slow, patience_s=60.0)], LEASE_S) as guarding:
        guarding.renew_lease()
        assert next(stopped(guarding)) == Report("stop", ("left_motor",), ())


def test_left_by_an_exception_it_stops_the_motors(diary: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(KeyError), Guardian([cutoff(diary)], LEASE_S):
        raise KeyError
    assert deeds(diary)[1:] == ["stop left_motor", "close left_motor"]
    assert f"the run of process {os.getpid()} broke off; stopped left_motor" in capfd.readouterr().err


def test_two_in_one_process_do_not_hold_each_other_open(diary: Path, tmp_path: Path) -> None:
    first, other = Guardian([cutoff(diary)], LEASE_S), tmp_path / "other"
    with Guardian([cutoff(other)], LEASE_S):
        with first:
            pass
        assert deeds(diary)[-1] == "close left_motor"
        assert deeds(other) == ["open left_motor"]


@pytest.mark.parametrize(
    "spec, fault",
    [
        (CutoffSpec("arm", "no_such_module:Cutoff"), "arm: ModuleNotFoundError: No module named 'no_such_module'"),
        (CutoffSpec("arm", "robotcore.safety.guardian:Missing"), "arm: AttributeError: .*'Missing'"),
        (
            CutoffSpec("arm", "robotcore.hal.wall_clock:MonotonicClock"),
            "arm: TypeError: .* is no robotcore.hal.cutoff.Cutoff",
        ),
        (CutoffSpec("arm", "robotcore.hal.cutoff:CutoffSpec"), "arm: TypeError: .*missing.*"),
        (cutoff(Path(os.devnull), "arm", "fails to open"), "arm: OSError: no open"),
    ],
)
def test_a_cutoff_that_cannot_be_had_is_named_by_name_before_anything_moves(spec: CutoffSpec, fault: str) -> None:
    with pytest.raises(GuardianError, match=f"cannot open {fault}. Nothing has moved"):
        Guardian([spec], LEASE_S)


def test_what_json_cannot_tell_is_refused() -> None:
    with pytest.raises(GuardianError, match=r"plain data alone: .*Path.* Mend the driver's cutoffs"):
        Guardian([CutoffSpec("arm", "robotcore.hal.cutoff:Cutoff", {"file": Path()})], LEASE_S)


def test_a_guardian_that_takes_too_long_is_not_waited_for(diary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "START_TIMEOUT_S", 0.5)
    with pytest.raises(GuardianError, match=r"is not ready within 0.5 s. Nothing has moved"):
        Guardian([cutoff(diary, manner="hangs in open")], LEASE_S)


def test_a_guardian_that_dies_as_it_starts_is_reported(diary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "_CODE", "raise SystemExit(7)")
    with pytest.raises(GuardianError, match=r"died \(exit status 7\). Nothing has moved"):
        Guardian([cutoff(diary)], LEASE_S)


@pytest.mark.skipif(sys.platform != "linux", reason="the limit is one of Linux's address space")
def test_a_guardian_whose_threads_are_refused_begins_no_run(diary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    limit = "import resource; resource.setrlimit(resource.RLIMIT_AS, (1, resource.RLIM_INFINITY)); main()"
    monkeypatch.setattr(client, "_CODE", client._CODE.replace("main()", limit))
    with pytest.raises(GuardianError, match="refuses the thread"):
        Guardian([cutoff(diary)], LEASE_S)
    assert not diary.exists()


def test_a_python_that_cannot_be_started_is_reported(diary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.executable", "/nowhere/python")
    with pytest.raises(GuardianError, match="no guardian process can be started: No such file"):
        Guardian([cutoff(diary)], LEASE_S)


def test_once_it_has_died_no_command_is_guarded(diary: Path) -> None:
    with Guardian([cutoff(diary)], LEASE_S) as guarding:
        os.kill(notes(diary)[0].process, signal.SIGKILL)
        with pytest.raises(GuardianError, match=r"died \(Killed"):
            next(stopped(guarding))
        with pytest.raises(GuardianError, match=r"died \(Killed"):
            guarding.renew_lease()


def test_more_commands_than_it_reads_are_no_more_words_to_it(diary: Path) -> None:
    with Guardian([cutoff(diary)], LEASE_S) as guarding:
        os.kill(notes(diary)[0].process, signal.SIGSTOP)
        for _ in range(5000):
            guarding.renew_lease()
        os.kill(notes(diary)[0].process, signal.SIGCONT)


def test_one_that_is_full_of_words_does_not_listen(diary: Path) -> None:
    with Guardian([cutoff(diary)], LEASE_S) as guarding:
        os.kill(notes(diary)[0].process, signal.SIGSTOP)
        with pytest.raises(GuardianError, match="does not listen"):  # noqa: PT012  the one that is too much
            for _ in range(100_000):
                guarding.renew_lease()
                guarding.end_lease()
        os.kill(notes(diary)[0].process, signal.SIGCONT)
