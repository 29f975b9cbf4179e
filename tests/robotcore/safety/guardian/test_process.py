from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.errors import ResourceError
from robotcore.safety.guardian import process
from robotcore.safety.guardian.process import stop_once
from robotcore.safety.guardian.protocol import Report
from tests.robotcore.safety.guardian.doubles import cutoff
from tests.robotcore.safety.guardian.recorder import notes


@pytest.fixture
def diary(tmp_path: Path) -> Path:
    return tmp_path / "diary"


def test_every_cutoff_stops_and_is_closed(diary: Path) -> None:
    report = stop_once([cutoff(diary, "left_motor"), cutoff(diary, "right_motor")])
    assert report == Report("stop", ("left_motor", "right_motor"), ())
    deeds = [note.what for note in notes(diary)]
    assert sorted(deeds) == sorted(f"{deed} {name}" for deed in ("open", "stop", "close") for name in report.done)


def test_one_that_fails_is_reported_and_holds_up_no_other(diary: Path) -> None:
    manners = {"gone": "fails to open", "deaf": "fails to stop", "left_motor": "late"}
    report = stop_once(cutoff(diary, name, manner) for name, manner in manners.items())
    assert report.done == ("left_motor",)
    assert report.failed == ("gone: OSError: no open", "deaf: OSError: no stop")
    assert "stop gone" not in {note.what for note in notes(diary)}


def test_one_that_cannot_tell_is_not_said_to_have_stopped(diary: Path) -> None:
    report = stop_once([cutoff(diary, "left_motor"), cutoff(diary, "right_motor", "is unsure")])
    assert report == Report("stop", ("left_motor",), (), ("right_motor: nobody can tell",))


def test_a_system_that_refuses_threads_keeps_no_motor_from_its_stop(
    diary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(target: object, name: str) -> None:
        raise ResourceError(name)

    monkeypatch.setattr(process, "start_thread", refuse)
    report = stop_once([cutoff(diary, "gone", "fails to open"), cutoff(diary, "left_motor")])
    assert (report.done, report.failed) == (("left_motor",), ("gone: OSError: no open",))
