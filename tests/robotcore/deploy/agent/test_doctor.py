from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from robotcore.deploy.agent import doctor
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.releases import ENVIRONMENT, Release
from tests.robotcore.deploy.agent.sample_releases import NEW, send_release

OURS, ANOTHERS = 1234, 4321


@pytest.fixture(autouse=True)
def _processes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two processes as Debian 12 tells of them: one of the service, one of a login."""
    groups = {OURS: "user@1000.service/app.slice/robotcore.service", ANOTHERS: "session-15.scope"}
    for pid, group in groups.items():
        (tmp_path / "proc" / str(pid)).mkdir(parents=True)
        (tmp_path / "proc" / str(pid) / "cgroup").write_text(f"0::/user.slice/user-1000.slice/{group}\n")
    monkeypatch.setattr(doctor, "_PROC", tmp_path / "proc")


def findings_of(layout: Layout, source: str) -> list[doctor.FindingRow]:
    folder = send_release(layout, NEW, doctor=source)
    (folder / ENVIRONMENT / "bin").mkdir(parents=True)
    (folder / ENVIRONMENT / "bin" / "python").symlink_to(sys.executable)
    return doctor.run_doctor(folder, Release.read(folder))


def finding(said: str) -> str:
    row = {"about": "raspberrypi", "level": "error", "what": "pins", "said": said, "remedy": "End that program"}
    return f"print({json.dumps(json.dumps({'findings': [row]}))})"


def test_a_pin_that_the_running_release_holds_is_no_fault(layout: Layout) -> None:
    (row,) = findings_of(layout, finding(f"GPIO 17 (left) is held by process {OURS} (python)"))
    assert (row["level"], row["remedy"]) == ("ok", "")
    assert row["said"].startswith("GPIO 17 (left) is held by")


@pytest.mark.parametrize(
    "holder",
    [f"process {ANOTHERS} (python)", f"process {OURS} (x) or process {ANOTHERS} (y)", "process 9 (z)", "somebody"],
)
def test_a_pin_that_somebody_else_holds_is_one(layout: Layout, holder: str) -> None:
    (row,) = findings_of(layout, finding(f"GPIO 17 (left) is held by {holder}"))
    assert (row["level"], row["remedy"]) == ("error", "End that program")


@pytest.mark.parametrize(
    "source, said",
    [
        ("import nothing_of_that_name", "does not run: ModuleNotFoundError: No module named 'nothing_of_that_name'"),
        ("import os; os.abort()", "does not run: it ended with -6"),
        ("print('[]')", "does not run: it ended with 0"),
        ("print('junk')", "does not run: it ended with 0"),
    ],
)
def test_a_doctor_that_does_not_run_is_a_finding(layout: Layout, source: str, said: str) -> None:
    (row,) = findings_of(layout, source)
    assert (row["level"], row["said"]) == ("error", said)


def test_a_doctor_that_hangs_is_a_finding(layout: Layout, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "DOCTOR_TIMEOUT_S", 0.1)
    (row,) = findings_of(layout, "import time; time.sleep(60)")
    assert row["said"] == "has not ended within 0.1 s"
