from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from socket import socket
from subprocess import Popen

import pytest

from robotcore.errors import GuardianError
from robotcore.hal.cutoff import CutoffSpec
from robotcore.safety.guardian import client
from robotcore.safety.guardian.client import Guardian
from robotcore.safety.guardian.protocol import GuardianReply
from tests.robotcore.safety.guardian.doubles import cutoff
from tests.robotcore.safety.guardian.recorder import notes
from tests.texts import CheckText, Raises

LEASE_S = 0.2


@pytest.fixture
def diary(tmp_path: Path) -> Path:
    return tmp_path / "diary"


def actions(diary: Path) -> list[str]:
    return [note.action for note in notes(diary)]


def number(diary: Path) -> int:
    """Return the number of the guardian's process."""
    return notes(diary)[0].process


@pytest.fixture
def process_numbers(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return a list to which the number of each guardian process is added."""
    numbers: list[int] = []
    start = client._start_process

    def start_and_record() -> tuple[Popen[bytes], socket]:
        process, link = start()
        numbers.append(process.pid)
        return process, link

    monkeypatch.setattr(client, "_start_process", start_and_record)
    return numbers


def wait_for_stops(guarding: Guardian) -> Iterator[GuardianReply]:
    while True:
        yield from guarding.stops()


@pytest.mark.slow
def test_guardian_stops_a_motor_after_the_lease(diary: Path) -> None:
    with Guardian([cutoff(diary)], LEASE_S) as guarding:
        guarding.renew_lease()
        assert next(wait_for_stops(guarding)) == GuardianReply("stop", ("left_motor",), ())
    assert actions(diary) == ["open left_motor", "arm left_motor", "stop left_motor", "close left_motor"]


def test_lease_is_renewed_at_most_once_in_a_short_time(diary: Path) -> None:
    with Guardian([cutoff(diary)], LEASE_S) as guarding:
        assert [guarding.renew_lease(), guarding.renew_lease()] == [True, False]


@pytest.mark.slow
def test_cutoff_that_hangs_does_not_delay_the_others(diary: Path, raises: Raises) -> None:
    cutoffs = [cutoff(diary, "stuck", "hangs in stop"), cutoff(diary, "left_motor"), cutoff(diary, "right_motor")]
    with Guardian(cutoffs, LEASE_S) as guarding:
        guarding.renew_lease()
        with raises(GuardianError, "guardian-action-failed", hide=[number(diary)]):
            next(wait_for_stops(guarding))
        assert {"stop left_motor", "stop right_motor"} <= set(actions(diary))


@pytest.mark.slow
def test_error_of_a_failed_stop_warns_of_a_turning_motor(diary: Path, raises: Raises) -> None:
    with Guardian([cutoff(diary, manner="fails to stop")], LEASE_S) as guarding:
        guarding.renew_lease()
        with raises(GuardianError, "guardian-action-failed", hide=[number(diary)]) as caught:
            next(wait_for_stops(guarding))
        assert client._MAY_TURN in str(caught.value)
        assert client._RUN_STOPPED not in str(caught.value)


@pytest.mark.slow
def test_failed_stop_of_a_cutoff_is_repeated(diary: Path) -> None:
    with Guardian([cutoff(diary, manner="late")], LEASE_S) as guarding:
        guarding.renew_lease()
        assert next(wait_for_stops(guarding)).done == ("left_motor",)


def test_cutoff_that_cannot_be_armed_is_reported(diary: Path, raises: Raises) -> None:
    with Guardian([cutoff(diary, manner="fails to arm")], LEASE_S) as guarding:
        guarding.renew_lease()
        with raises(GuardianError, "guardian-action-failed", hide=[number(diary)]):
            next(wait_for_stops(guarding))


@pytest.mark.slow
def test_patience_of_a_cutoff_extends_the_time_to_arm(diary: Path, raises: Raises) -> None:
    slow = cutoff(diary, manner="is slow to arm")
    with Guardian([slow], LEASE_S) as guarding:
        guarding.renew_lease()
        with raises(GuardianError, "guardian-action-failed", hide=[number(diary)]):
            next(wait_for_stops(guarding))
    with Guardian([replace(slow, extra_lease_s=60.0)], LEASE_S) as guarding:
        guarding.renew_lease()
        assert next(wait_for_stops(guarding)) == GuardianReply("stop", ("left_motor",), ())


def test_exception_in_the_context_stops_the_motors(
    diary: Path, capfd: pytest.CaptureFixture[str], check_text: CheckText
) -> None:
    with pytest.raises(KeyError), Guardian([cutoff(diary)], LEASE_S):
        raise KeyError
    assert actions(diary)[1:] == ["stop left_motor", "close left_motor"]
    check_text(capfd.readouterr().err, hide=[os.getpid()])


@pytest.mark.slow
def test_two_guardians_of_one_process_end_independently(diary: Path, tmp_path: Path) -> None:
    first, other = Guardian([cutoff(diary)], LEASE_S), tmp_path / "other"
    with Guardian([cutoff(other)], LEASE_S):
        with first:
            pass
        assert actions(diary)[-1] == "close left_motor"
        assert actions(other) == ["open left_motor"]


@pytest.mark.parametrize(
    "spec",
    [
        CutoffSpec("arm", "no_such_module:Cutoff"),
        CutoffSpec("arm", "robotcore.safety.guardian:Missing"),
        CutoffSpec("arm", "robotcore.hal.wall_clock:MonotonicClock"),
        CutoffSpec("arm", "robotcore.hal.cutoff:CutoffSpec"),
        cutoff(Path(os.devnull), "arm", "fails to open"),
    ],
    ids=["no module", "no class", "another class", "no argument", "open fails"],
)
def test_cutoff_that_cannot_be_opened_is_reported_before_anything_moves(
    spec: CutoffSpec, process_numbers: list[int], raises: Raises
) -> None:
    with raises(GuardianError, "cutoff-not-opened", hide=process_numbers):
        Guardian([spec], LEASE_S)


def test_parameters_that_are_not_json_data_are_refused(raises: Raises) -> None:
    with raises(GuardianError, "cutoff-not-json", hide=[type(Path()).__name__]):
        Guardian([CutoffSpec("arm", "robotcore.hal.cutoff:Cutoff", {"file": Path()})], LEASE_S)


@pytest.mark.slow
def test_wait_for_the_start_of_a_guardian_is_limited(
    diary: Path, monkeypatch: pytest.MonkeyPatch, process_numbers: list[int], raises: Raises
) -> None:
    monkeypatch.setattr(client, "START_TIMEOUT_S", 0.5)
    with raises(GuardianError, "guardian-late", hide=process_numbers):
        Guardian([cutoff(diary, manner="hangs in open")], LEASE_S)


def test_death_of_a_guardian_at_its_start_is_reported(
    diary: Path, monkeypatch: pytest.MonkeyPatch, process_numbers: list[int], raises: Raises
) -> None:
    monkeypatch.setattr(client, "_CODE", "raise SystemExit(7)")
    with raises(GuardianError, "guardian-died", hide=process_numbers):
        Guardian([cutoff(diary)], LEASE_S)


@pytest.mark.linux("the limit is one of Linux's address space")
def test_guardian_without_threads_begins_no_run(
    diary: Path, monkeypatch: pytest.MonkeyPatch, process_numbers: list[int], raises: Raises
) -> None:
    limit = "import resource; resource.setrlimit(resource.RLIMIT_AS, (1, resource.RLIM_INFINITY)); main()"
    monkeypatch.setattr(client, "_CODE", client._CODE.replace("main()", limit))
    with raises(GuardianError, "cutoff-not-opened", hide=process_numbers):
        Guardian([cutoff(diary)], LEASE_S)
    assert not diary.exists()


def test_python_that_cannot_be_started_is_reported(
    diary: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr("sys.executable", "/nowhere/python")
    with raises(GuardianError, "guardian-not-started"):
        Guardian([cutoff(diary)], LEASE_S)


def test_dead_guardian_refuses_a_lease(diary: Path, raises: Raises) -> None:
    with Guardian([cutoff(diary)], LEASE_S) as guarding:
        os.kill(number(diary), signal.SIGKILL)
        with raises(GuardianError, "guardian-died", hide=[number(diary), signal.strsignal(signal.SIGKILL)]):
            next(wait_for_stops(guarding))
        with raises(GuardianError, "guardian-died", hide=[number(diary), signal.strsignal(signal.SIGKILL)]):
            guarding.renew_lease()


def test_second_renewal_within_a_moment_sends_nothing(diary: Path) -> None:
    with Guardian([cutoff(diary)], LEASE_S) as guarding:
        os.kill(number(diary), signal.SIGSTOP)
        for _ in range(5000):
            guarding.renew_lease()
        os.kill(number(diary), signal.SIGCONT)


@pytest.mark.slow
def test_guardian_that_reads_no_commands_is_reported(diary: Path, raises: Raises) -> None:
    with Guardian([cutoff(diary)], LEASE_S) as guarding:
        os.kill(number(diary), signal.SIGSTOP)
        with raises(GuardianError, "guardian-overflow", hide=[number(diary)]):
            for _ in range(100_000):
                guarding.renew_lease()
                guarding.end_lease()
        os.kill(number(diary), signal.SIGCONT)
