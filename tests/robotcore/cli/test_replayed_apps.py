"""``robotcore replay`` with an app file that has changed, is missing, raises, or decides by chance."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from tests.robotcore.cli.conftest import AppFile, Cli
from tests.robotcore.recording.mcap_builder import change_json
from tests.texts import CheckText

CHOOSING = """
from __future__ import annotations
import sys
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, Literal, Optional
from robotcore import Behaviour, Role, Status

class Colour(Enum):
    RED = "red"

print("imported", file=sys.stderr)

@dataclass
class Choosing(Behaviour):
    log: str = "run.log"
    place: Optional[Path] = None
    thing: Any = None
    speed: Annotated[float, "m/s"] = 0.1
    count: int | None = 3
    is_quick: bool = False
    colour: Colour | Literal["blue"] = Colour.RED
    needs = frozenset({Role.DRIVE})

    def step(self, robot):
        Path(self.log).write_text("written")
        return Status.SUCCESS
"""


@pytest.fixture(autouse=True)
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make a temporary folder the current folder, in which the tests write apps."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def chosen(cli: Cli, project: Path) -> Path:
    """Record an app that has settings of many types, and return the recording's file."""
    app, file = project / "choosing.py", project / "chosen.mcap"
    app.write_text(CHOOSING)
    assert cli("run", "choosing.py", "--record", str(file)).status in (0, 1)
    (project / "run.log").unlink()
    return file


def change_settings(file: Path, settings: dict[str, object], app: str = "choosing.py") -> str:
    """Write a copy of a recording with other settings or another app, and return its name."""
    forged = file.with_name("forged.mcap")
    request = {"settings": settings, "app": app}
    forged.write_bytes(change_json(file, "/run", lambda _, event: event | {"request": event["request"] | request}))
    return str(forged)


def hide_samples(output: str) -> str:
    """Return an output without samples and other numbers that the platform may change."""
    return re.sub(r"read in this tick:[^)]*\)(;[^)]*\))*", "read in this tick: …", re.sub(r"\d+\.\d{4,}", "…", output))


def test_own_app_that_has_changed_is_reported_with_the_first_difference(
    cli: Cli, app_file: AppFile, tmp_path: Path, check_text: CheckText
) -> None:
    app, file = app_file("pass"), str(tmp_path / "own.mcap")
    assert cli("run", app, "--timeout", "1", "--record", file).status == 1
    same = cli("replay", file)
    assert same.status == 0
    assert cli("replay", file, "--json").json["app_changed"] is False
    app_file("robot.drive.set_velocity(0.125, 0.0)")
    answers = cli("replay", file, "--app", app)
    assert answers.status == 1
    check_text(hide_samples(answers.out))
    assert cli("replay", file, "--app", app, "--json").json["deviation"]["tick"] == 2


def test_own_app_that_has_changed_but_decides_the_same_is_reported(
    cli: Cli, app_file: AppFile, tmp_path: Path, check_text: CheckText
) -> None:
    app, file = app_file("pass"), str(tmp_path / "own.mcap")
    cli("run", app, "--timeout", "1", "--record", file)
    app_file("...")
    answers = cli("replay", file, "--app", app)
    assert answers.status == 0
    check_text(answers.out.splitlines()[-1])
    assert cli("replay", file, "--app", app, "--json").json["app_changed"] is True


def test_own_app_that_is_the_same_but_decides_otherwise_may_depend_on_chance(
    cli: Cli, app_file: AppFile, tmp_path: Path, check_text: CheckText
) -> None:
    chance = "robot.drive.set_velocity(int.from_bytes(os.urandom(3), 'big') * 1e-8, 0.0)"
    file = str(tmp_path / "own.mcap")
    cli("run", app_file(chance), "--timeout", "1", "--record", file)
    answers = cli("replay", file)
    assert answers.status == 1
    check_text(answers.out.splitlines()[-1])


def test_missing_own_app_is_named_with_the_remedy(
    cli: Cli, app_file: AppFile, tmp_path: Path, check_text: CheckText
) -> None:
    app, file = app_file("pass"), str(tmp_path / "own.mcap")
    cli("run", app, "--timeout", "1", "--record", file)
    Path(app).unlink()
    answers = cli("replay", file)
    assert answers.status == 2
    check_text(answers.err)
    assert cli("replay", file, "--set", "speed=1").err == answers.err


def test_own_app_that_raises_now_is_reported_with_its_traceback(
    cli: Cli, app_file: AppFile, tmp_path: Path, check_text: CheckText
) -> None:
    app, file = app_file("pass"), str(tmp_path / "own.mcap")
    cli("run", app, "--timeout", "1", "--record", file)
    app_file("1 / 0")
    answers = cli("replay", file, "--app", app)
    assert answers.status == 1
    check_text(hide_samples(answers.out))
    check_text(answers.plain_err)


def test_app_that_raised_in_the_recording_is_replayed_silently(cli: Cli, app_file: AppFile, tmp_path: Path) -> None:
    file = str(tmp_path / "own.mcap")
    assert cli("run", app_file("1 / 0"), "--record", file).status == 5
    answers = cli("replay", file)
    assert (answers.status, answers.err) == (0, "")


def test_run_that_a_signal_ended_names_the_signal(
    cli: Cli, app_file: AppFile, tmp_path: Path, check_text: CheckText
) -> None:
    file = str(tmp_path / "own.mcap")
    app = app_file("os.kill(os.getpid(), signal.SIGTERM)")
    assert cli("run", app, "--record", file).status == 143
    app_file("pass")
    answers = cli("replay", file, "--app", app)
    assert answers.status == 0
    check_text(answers.out, hide=re.findall("[0-9a-f]{64}", answers.out))


def test_different_end_is_reported_after_equal_decisions(
    cli: Cli, app_file: AppFile, tmp_path: Path, check_text: CheckText
) -> None:
    app, file = app_file("return Status.SUCCESS"), str(tmp_path / "own.mcap")
    cli("run", app, "--record", file)
    app_file("return Status.FAILURE")
    answers = cli("replay", file, "--app", app)
    check_text(hide_samples(answers.out))


def test_changed_app_of_equal_time_and_size_is_imported_anew(cli: Cli, app_file: AppFile, tmp_path: Path) -> None:
    app, file = app_file("return Status.SUCCESS"), str(tmp_path / "own.mcap")
    before = Path(app).stat()
    cli("run", app, "--record", file)
    app_file("return Status.FAILURE")
    os.utime(app, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert cli("replay", file, "--app", app).status == 1


@pytest.mark.parametrize("arguments", [(), ("--set", "speed=1")], ids=["verified", "evaluated"])
@pytest.mark.parametrize("place", ["absolute", "relative", "above", "beside"])
def test_a_file_that_differs_from_the_recorded_text_is_not_run(
    cli: Cli,
    app_file: AppFile,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    place: str,
    arguments: tuple[str, ...],
) -> None:
    own, file, proof = tmp_path / "own.mcap", tmp_path / "sent" / "run.mcap", tmp_path / "proof"
    cli("run", app_file("return Status.SUCCESS"), "--record", str(own))
    for folder in ("sent", "work"):
        (tmp_path / folder).mkdir()
    monkeypatch.chdir(tmp_path / "work")
    evil = {
        "absolute": str(tmp_path / "evil.py"),
        "relative": "evil.py",
        "above": "../evil.py",
        "beside": str(file.with_name("evil.py")),
    }[place]
    Path(evil).write_text(f"open({str(proof)!r}, 'w')\n{Path(tmp_path / 'odd.py').read_text()}")
    request = {"app": evil}
    file.write_bytes(change_json(own, "/run", lambda _, event: event | {"request": event["request"] | request}))
    answer = cli("replay", str(file), *arguments)
    assert (answer.status, answer.out) == (2, "")
    assert evil in answer.err
    assert not proof.exists()


def test_file_without_a_recorded_text_is_not_run(cli: Cli, app_file: AppFile, tmp_path: Path) -> None:
    app, own, file = app_file("return Status.SUCCESS"), tmp_path / "own.mcap", tmp_path / "run.mcap"
    cli("run", app, "--record", str(own))
    file.write_bytes(change_json(own, "/run", lambda _, event: {**event, "source": None}))
    assert cli("replay", str(file)).status == 2
    assert cli("replay", str(file), "--app", app).status == 0


def test_moved_own_app_is_verified_by_its_new_name(cli: Cli, app_file: AppFile, tmp_path: Path) -> None:
    file, elsewhere = str(tmp_path / "own.mcap"), tmp_path / "elsewhere"
    app = Path(app_file("return Status.SUCCESS"))
    cli("run", str(app), "--record", file)
    elsewhere.mkdir()
    moved = app.rename(elsewhere / "other.py")
    answer = cli("replay", file, "--app", str(moved), "--json").json
    assert (answer["bit_equal"], answer["app_changed"]) == (True, False)


def test_another_named_file_is_evaluated(cli: Cli, app_file: AppFile, tmp_path: Path) -> None:
    app, file = Path(app_file("return Status.SUCCESS")), str(tmp_path / "own.mcap")
    cli("run", str(app), "--record", file)
    other = tmp_path / "other.py"
    other.write_text(app.read_text().replace("SUCCESS", "FAILURE"))
    assert "recorded_app" in cli("replay", file, "--app", str(other), "--json").json


@pytest.mark.parametrize(
    "settings", [{"log": "evil"}, {"place": "evil"}, {"thing": "1"}, {"thing": [1]}, {"speed": 0.1, "log": ""}], ids=str
)
@pytest.mark.parametrize("arguments", [(), ("--set", "speed=1")], ids=["verified", "evaluated"])
def test_a_text_setting_of_a_recording_reaches_only_an_app_that_the_user_names(
    cli: Cli,
    project: Path,
    chosen: Path,
    settings: dict[str, object],
    arguments: tuple[str, ...],
    check_text: CheckText,
) -> None:
    file = change_settings(chosen, settings)
    before = sorted(project.iterdir())
    answer = cli("replay", file, *arguments)
    assert (answer.status, answer.out) == (2, "")
    check_text(answer.err)
    assert sorted(each for each in project.iterdir() if each.name != "__pycache__") == before


@pytest.mark.parametrize(
    "settings",
    [
        {"speed": "0.25", "count": "4", "is_quick": "yes"},
        {"speed": 0.25, "count": None, "is_quick": True, "colour": "red"},
        {"colour": "blue", "log": "run.log", "place": None},
    ],
    ids=str,
)
def test_numbers_choices_and_defaults_of_a_recording_are_set(
    cli: Cli, chosen: Path, settings: dict[str, object]
) -> None:
    assert cli("replay", change_settings(chosen, settings)).status == 0


def test_text_of_a_recording_is_set_if_the_user_names_the_app(cli: Cli, project: Path, chosen: Path) -> None:
    assert cli("replay", change_settings(chosen, {"log": "other.log"}), "--app", "choosing.py").status == 0
    assert (project / "other.log").exists()


def test_a_text_setting_of_the_user_replaces_the_recorded_one(cli: Cli, project: Path, chosen: Path) -> None:
    assert cli("replay", change_settings(chosen, {"log": "evil"}), "--set", "log=mine.log").status == 0
    assert (project / "mine.log").exists()
    assert not (project / "evil").exists()


@pytest.mark.parametrize("place", ["outside", "above", "link", "site-packages", "environment"])
def test_recorded_text_is_not_run_outside_of_the_project(
    cli: Cli, project: Path, chosen: Path, monkeypatch: pytest.MonkeyPatch, place: str, check_text: CheckText
) -> None:
    elsewhere, work = project / "elsewhere.py", project / "work"
    (work / "site-packages").mkdir(parents=True)
    (work / "environment").mkdir()
    elsewhere.write_text(CHOOSING)
    for folder in ("site-packages", "environment"):
        (work / folder / "app.py").write_text(CHOOSING)
    (work / "link.py").symlink_to(elsewhere)
    monkeypatch.chdir(work)
    monkeypatch.setattr("sys.prefix", str(work / "environment"))
    apps = {"outside": str(elsewhere), "above": "../elsewhere.py", "link": "link.py"}
    app = apps.get(place, f"{place}/app.py")
    answer = cli("replay", change_settings(chosen, {}, app))
    assert (answer.status, answer.out) == (2, "")
    assert "imported" not in answer.err
    check_text(answer.err)
    assert cli("replay", change_settings(chosen, {}, app), "--app", app).status == 0


@pytest.mark.parametrize("folder", ["", "apps"])
def test_recorded_text_below_the_current_folder_runs_by_an_absolute_path_too(
    cli: Cli, project: Path, chosen: Path, folder: str
) -> None:
    (project / folder).mkdir(exist_ok=True)
    app = project / folder / "choosing.py"
    app.write_text(CHOOSING)
    assert cli("replay", change_settings(chosen, {}, str(app))).status == 0
    assert cli("replay", change_settings(chosen, {}, str(app.relative_to(project)))).status == 0
