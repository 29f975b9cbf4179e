"""``--junit`` of sweeps and replays, and ``--badge`` of sweeps."""

from __future__ import annotations

import errno
import os
import shutil
import signal
from collections.abc import Callable
from pathlib import Path
from unittest.mock import Mock

import pytest

from robotcore import RunRequest
from robotcore.errors import BackendError, Interrupted
from tests.robotcore.cli.conftest import Cli
from tests.robotcore.junit_schema import read_junit
from tests.texts import CheckText

SWEEP = ("sweep", "green-search", "--timeout", "0.1", "--world", "open", "--seeds", "1-2", "--out", "here")

STEADY = """
from robotcore import Behaviour, Role, Status

class Steady(Behaviour):
    needs = frozenset({Role.DRIVE})

    def step(self, robot):
        robot.drive.set_velocity(0.1, 0.0)
        return Status.SUCCESS if robot.clock.now() > 0.5 else Status.RUNNING
"""


@pytest.fixture(autouse=True)
def _enter_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def recording(tmp_path: Path, cli: Cli) -> Path:
    """Record an app in its file ``steady.py``."""
    (tmp_path / "steady.py").write_text(STEADY)
    assert cli("run", "steady.py", "--record", "run.mcap").status == 0
    return Path("run.mcap")


def list_problems(file: str) -> list[tuple[str, str]]:
    """Return the verdict and the kind of each case that did not pass."""
    cases = read_junit(Path(file).read_bytes()).iter("testcase")
    return [(each.tag, each.attrib["type"]) for case in cases for each in case if "type" in each.attrib]


@pytest.mark.slow
def test_a_sweep_writes_its_runs_and_its_gate_also_from_saved_results(cli: Cli, requests: list[RunRequest]) -> None:
    arguments = (*SWEEP, "--require", "verified>=0.9", "--junit", "sweep.xml", "--badge", "sweep.svg")
    done = cli(*arguments)
    assert (done.status, len(requests)) == (1, 2)
    assert done.out.endswith("The JUnit file: sweep.xml\nThe badge: sweep.svg\n")
    assert list_problems("sweep.xml") == [("failure", "timeout")] * 2 + [("failure", "gate")]
    assert "failed: 0 % of 2 runs verified" in Path("sweep.svg").read_text()
    again = cli(*SWEEP, "--require", "contacts<=0", "--junit", "sweep.xml", "--badge", "sweep.svg", "--json")
    assert (again.status, len(requests), again.json["done"]) == (0, 2, 2)
    assert again.err == "The JUnit file: sweep.xml\nThe badge: sweep.svg\n"
    assert list_problems("sweep.xml") == [("skipped", "timeout")] * 2
    assert "passed: 0 % of 2 runs verified" in Path("sweep.svg").read_text()


@pytest.mark.slow
def test_a_sweep_whose_engine_fails_is_a_case_with_an_error(
    cli: Cli, requests: list[RunRequest], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robotcore.sweep.engine.LocalEngine.perform", Mock(side_effect=BackendError("gone")))
    Path("sweep.svg").write_text("old")
    assert cli(*SWEEP, "--junit", "sweep.xml", "--badge", "sweep.svg").status == 3
    assert list_problems("sweep.xml") == [("error", "backend")]
    assert ">error<" in Path("sweep.svg").read_text()


@pytest.mark.slow
def test_an_interrupted_sweep_keeps_the_old_files(
    cli: Cli, requests: list[RunRequest], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robotcore.sweep.engine.LocalEngine.perform", Mock(side_effect=Interrupted(signal.SIGTERM)))
    for name in ("sweep.xml", "sweep.svg"):
        Path(name).write_text("old")
    assert cli(*SWEEP, "--junit", "sweep.xml", "--badge", "sweep.svg").status == 128 + signal.SIGTERM
    assert [Path(name).read_text() for name in ("sweep.xml", "sweep.svg")] == ["old", "old"]


@pytest.mark.slow
def test_an_app_that_cannot_be_imported_is_a_case_with_its_traceback(cli: Cli, requests: list[RunRequest]) -> None:
    Path("broken.py").write_text("1 / 0\n")
    Path("sweep.svg").write_text("passed: 100 %")
    done = cli("sweep", "broken.py", "--junit", "sweep.xml", "--badge", "sweep.svg")
    assert (done.status, requests) == (5, [])
    assert ">error<" in Path("sweep.svg").read_text()
    assert list_problems("sweep.xml") == [("error", "app-not-importable")]
    text = read_junit(Path("sweep.xml").read_bytes()).findtext(".//error") or ""
    assert 'File "broken.py", line 1' in text
    assert text.endswith("\nRepeat the command: robotcore sweep broken.py --junit sweep.xml --badge sweep.svg")


def test_a_wrong_name_is_a_case_with_an_error(cli: Cli) -> None:
    assert cli("sweep", "green-serch", "--junit", "sweep.xml").status == 2
    assert list_problems("sweep.xml") == [("error", "unknown-app")]


@pytest.mark.slow
@pytest.mark.parametrize("option, name", [("--junit", "sweep.xml"), ("--badge", "sweep.svg")])
def test_a_file_that_does_not_fit_on_the_disk_is_reported_after_the_results(
    cli: Cli,
    requests: list[RunRequest],
    monkeypatch: pytest.MonkeyPatch,
    option: str,
    name: str,
    check_text: CheckText,
) -> None:
    Path(name).write_text("old")
    monkeypatch.setattr(Path, "write_bytes", Mock(side_effect=OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))))
    done = cli("sweep", "mark-green", "--world", "open", "--set", "duration_s=0.2", "--seeds", "1", option, name)
    assert (done.status, Path(name).read_text()) == (2, "old")
    assert "\nkinematic  open" in done.out
    assert [each.name for each in Path().iterdir() if each.name.startswith(".")] == []
    check_text(done.err)


BAD_FILES = [
    (("--junit", "sweep.txt"), "file-ending"),
    (("--junit", ""), "file-ending"),
    (("--junit", "nowhere/sweep.xml"), "file-not-writable"),
    (("--junit", "folder.xml"), "file-not-writable"),
    (("--junit", "link.xml"), "file-not-writable"),
    (("--badge", "badge.png"), "file-ending"),
    (("--badge", "nowhere/badge.svg"), "file-not-writable"),
]


@pytest.fixture
def make_unwritable_files() -> None:
    Path("folder.xml").mkdir()
    Path("link.xml").symlink_to("elsewhere.xml")


@pytest.mark.usefixtures("make_unwritable_files")
@pytest.mark.parametrize("options, kind", BAD_FILES)
def test_a_sweep_refuses_a_file_that_it_could_not_write_before_its_first_run(
    cli: Cli, requests: list[RunRequest], options: tuple[str, str], kind: str, check_text: CheckText
) -> None:
    done = cli("sweep", "green-search", *options, "--json")
    assert (done.status, done.json["kind"], requests) == (2, kind, [])
    assert not Path("sweeps").exists()
    check_text(done.err)


@pytest.mark.slow
def test_a_replay_passes_and_fails_as_its_exit_status_says(cli: Cli, recording: Path) -> None:
    done = cli("replay", str(recording), "--junit", "replay.xml")
    assert done.status == 0
    assert done.out.endswith("The JUnit file: replay.xml\n")
    root = read_junit(Path("replay.xml").read_bytes())
    assert [case.attrib["name"] for case in root.iter("testcase")] == ["run.mcap"]
    assert list_problems("replay.xml") == []
    Path("steady.py").write_text(STEADY.replace("0.1, 0.0", "0.2, 0.0"))
    done = cli("replay", str(recording), "--app", "steady.py", "--junit", "replay.xml", "--json")
    assert (done.status, done.err) == (1, "The JUnit file: replay.xml\n")
    failure = read_junit(Path("replay.xml").read_bytes()).find(".//failure")
    assert failure is not None
    assert failure.attrib == {"type": "deviation", "message": "tick 0, at 0 s, the command differs"}
    assert "\n  recorded: left " in (failure.text or "")
    assert (failure.text or "").endswith("\nRepeat the command: robotcore replay --app=steady.py run.mcap")


@pytest.mark.slow
def test_an_evaluation_passes_unless_its_app_raises(cli: Cli, recording: Path) -> None:
    (other := Path("other.py")).write_text(STEADY.replace("0.1, 0.0", "0.2, 0.0"))
    assert cli("replay", str(recording), "--app", "other.py", "--junit", "replay.xml").status == 0
    assert list_problems("replay.xml") == []
    assert "ticks differ" in Path("replay.xml").read_text()
    other.write_text(STEADY.replace("robot.drive", "robot.wings"))
    assert cli("replay", str(recording), "--app", "other.py", "--junit", "replay.xml").status == 5
    assert list_problems("replay.xml") == [("error", "behaviour")]
    assert "other.py" in (read_junit(Path("replay.xml").read_bytes()).findtext(".//error") or "")


@pytest.mark.slow
@pytest.mark.parametrize(
    "old, new, message",
    [
        ("class Steady", "# no change\nclass Steady", None),
        ("0.1, 0.0", "0.2, 0.0", "tick 0, at 0 s, the command differs"),
        ("> 0.5", "> 0.3", "the end of the run, or the sensors that were read, differ"),
        ("> 0.5", "> 9", "the end of the run, or the sensors that were read, differ"),
        ("Status.SUCCESS", "Status.FAILURE", "the end of the run, or the sensors that were read, differ"),
    ],
)
def test_require_equal_fails_if_another_app_decides_otherwise(
    cli: Cli, recording: Path, old: str, new: str, message: str | None
) -> None:
    Path("other.py").write_text(STEADY.replace(old, new))
    arguments = ("replay", str(recording), "--app", "other.py", "--json")
    assert cli(*arguments).json["exit_status"] == 0
    done = cli(*arguments, "--require-equal", "--junit", "replay.xml")
    assert done.status == done.json["exit_status"] == (1 if message else 0)
    failures = read_junit(Path("replay.xml").read_bytes()).iter("failure")
    assert [each.attrib["message"] for each in failures] == ([message] if message else [])


@pytest.mark.slow
def test_require_equal_fails_if_a_setting_changes_a_decision(cli: Cli, search_recording: Path) -> None:
    arguments = ("replay", str(search_recording), "--set", "speed_m_s=0.15")
    assert cli(*arguments).status == 0
    assert cli(*arguments, "--require-equal").status == 1


def cut_end(content: bytes) -> bytes:
    return content[:-8]


def cut_half(content: bytes) -> bytes:
    return content[: len(content) // 2 + 2000]


def flip_byte(content: bytes) -> bytes:
    at = len(content) // 2
    return content[:at] + bytes([content[at] ^ 0xFF]) + content[at + 1 :]


@pytest.mark.slow
@pytest.mark.parametrize("spoil", [cut_end, cut_half, flip_byte])
@pytest.mark.parametrize("options", [(), ("--app", "steady.py"), ("--app", "other.py")])
def test_require_equal_refuses_an_incomplete_recording(
    cli: Cli, recording: Path, spoil: Callable[[bytes], bytes], options: tuple[str, ...]
) -> None:
    Path("other.py").write_text(STEADY)
    recording.write_bytes(spoil(recording.read_bytes()))
    arguments = ("replay", str(recording), *options, "--require-equal", "--junit", "replay.xml", "--json")
    done = cli(*arguments)
    assert (done.status, done.json["kind"]) == (2, "recording-incomplete")
    assert list_problems("replay.xml") == [("error", "recording-incomplete")]


@pytest.mark.slow
def test_a_cut_recording_is_replayed_without_require_equal(cli: Cli, recording: Path) -> None:
    recording.write_bytes(cut_end(recording.read_bytes()))
    assert cli("replay", str(recording)).status == 0


@pytest.mark.slow
def test_an_interrupted_replay_keeps_the_old_file(cli: Cli, recording: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("replay.xml").write_text("old")
    Path("other.py").write_text(
        STEADY.replace("robot.drive", "import signal; signal.raise_signal(signal.SIGTERM); robot.drive")
    )
    assert cli("replay", str(recording), "--app", "other.py", "--junit", "replay.xml").status == 128 + signal.SIGTERM
    assert Path("replay.xml").read_text() == "old"


@pytest.mark.parametrize("content, kind", [(b"no recording", "not-a-recording"), (None, "recording-unreadable")])
def test_a_file_that_is_no_recording_is_a_case_with_an_error(cli: Cli, content: bytes | None, kind: str) -> None:
    if content is not None:
        Path("kept.mcap").write_bytes(content)
    done = cli("replay", "kept.mcap", "--junit", "replay.xml", "--json")
    assert (done.status, done.json["kind"]) == (2, kind)
    assert list_problems("replay.xml") == [("error", kind)]


def test_an_error_is_reported_also_if_its_junit_file_cannot_be_written(
    cli: Cli, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    Path("kept.mcap").write_bytes(b"no recording")
    monkeypatch.setattr(Path, "write_bytes", Mock(side_effect=OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))))
    done = cli("replay", "kept.mcap", "--junit", "replay.xml")
    assert done.status == 2
    check_text(done.err)


@pytest.mark.parametrize(
    "options, kind",
    [
        (("--junit", "run.mcap"), "output-is-input"),
        (("--junit", "replay.txt"), "file-ending"),
        (("--junit", "nowhere/replay.xml"), "file-not-writable"),
        (("--junit", "x.xml", "--record", "x.xml"), "same-output"),
        (("--junit", "x.xml", "--force"), "option-without-effect"),
        (("--junit", "x.png", "--picture", "sub/../x.png"), "same-output"),
    ],
)
def test_a_replay_refuses_a_file_that_it_could_not_write(
    cli: Cli, brief_recording: Path, options: tuple[str, ...], kind: str, check_text: CheckText
) -> None:
    shutil.copy(brief_recording, "run.mcap")
    Path("sub").mkdir()
    done = cli("replay", "run.mcap", *options, "--json")
    assert (done.status, done.json["kind"]) == (2, kind)
    assert sorted(each.name for each in Path().iterdir()) == ["run.mcap", "sub"]
    check_text(done.err)
