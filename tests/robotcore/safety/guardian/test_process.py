from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path
from socket import SHUT_WR, socketpair

import pytest

from robotcore.errors import ResourceError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.guardian import process
from robotcore.safety.guardian.process import CutoffWorker, GuardianProcess, run_all, stop_once
from robotcore.safety.guardian.protocol import BEGIN_LEASE, Assignment, GuardianReply
from robotcore.threads import start_thread
from tests.robotcore.safety.guardian.doubles import cutoff
from tests.robotcore.safety.guardian.recorder import Recorder, notes

PROCESS_MODULES = (
    "robotcore.safety.guardian.process",
    "drivers.raspberrypi.cutoff",
    "drivers.raspberrypi.pwm.cutoff",
    "drivers.serial.boards.cutoff",
    "drivers.coppeliasim.cutoff",
)
"""The modules that a guardian process imports."""

HEAVY = {"numpy", "cv2", "pydantic", "robotcore.description", "robotcore.kinds"}


@pytest.mark.parametrize("module", PROCESS_MODULES)
def test_guardian_process_imports_nothing_heavy(module: str) -> None:
    """A guardian starts beside the devices of a run, on boards with little memory."""
    code = f"import sys, {module}; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert HEAVY.isdisjoint(loaded)


@pytest.fixture
def diary(tmp_path: Path) -> Path:
    return tmp_path / "diary"


def test_every_cutoff_stops_and_is_closed(diary: Path) -> None:
    report = stop_once([cutoff(diary, "left_motor"), cutoff(diary, "right_motor")])
    assert report == GuardianReply("stop", ("left_motor", "right_motor"), ())
    actions = [note.action for note in notes(diary)]
    assert sorted(actions) == sorted(f"{action} {name}" for action in ("open", "stop", "close") for name in report.done)


@pytest.mark.slow
def test_a_cutoff_that_fails_is_reported_and_does_not_delay_the_others(diary: Path) -> None:
    manners = {"gone": "fails to open", "broken": "fails to stop", "left_motor": "late"}
    report = stop_once(cutoff(diary, name, manner) for name, manner in manners.items())
    assert report.done == ("left_motor",)
    assert report.failed == ("gone: OSError: no open", "broken: OSError: no stop")
    assert "stop gone" not in {note.action for note in notes(diary)}


def test_an_unconfirmed_stop_is_a_message_and_not_in_done(diary: Path) -> None:
    report = stop_once([cutoff(diary, "left_motor"), cutoff(diary, "right_motor", "is unsure")])
    assert report == GuardianReply("stop", ("left_motor",), (), ("right_motor: the port is gone",))


def test_only_a_stop_has_a_message(diary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Recorder, "open", lambda _: 3)
    worker = CutoffWorker(cutoff(diary), MonotonicClock(), runs_in_caller_thread=True)
    assert run_all([worker], "open", 1.0) == GuardianReply("open", ("left_motor",), ())


def test_motors_stop_also_if_the_system_refuses_threads(diary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(target: object, name: str) -> None:
        raise ResourceError(name)

    monkeypatch.setattr(process, "start_thread", refuse)
    report = stop_once([cutoff(diary, "gone", "fails to open"), cutoff(diary, "left_motor")])
    assert (report.done, report.failed) == (("left_motor",), ("gone: OSError: no open",))


def test_a_full_stderr_delays_neither_the_guardian_nor_the_closing_of_a_cutoff(
    diary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(process, "RETRYING_S", 0.0)
    logs: list[tuple[str, bool]] = []

    def log(_lines: object) -> None:
        is_closed = "close left_motor" in {note.action for note in notes(diary)}
        logs.append((threading.current_thread().name, is_closed))

    monkeypatch.setattr(process, "_log", log)
    app, link = socketpair()
    with app, link:
        cutoffs = cutoff(diary), cutoff(diary, "right_motor", "fails to stop")
        guardian = start_thread(GuardianProcess(link, Assignment(1, 0.05, cutoffs)).run, "guardian")
        app.sendall(BEGIN_LEASE)
        answers = b""
        while b"OSError: no stop" not in answers:
            answers += app.recv(4096)
        app.shutdown(SHUT_WR)
        guardian.join()
    assert sorted(name for name, _ in logs) == ["guardian", "log"]
    assert ("guardian", True) in logs
