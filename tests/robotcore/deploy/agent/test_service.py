from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from robotcore.deploy import rpc
from robotcore.deploy.agent import files, releases, service
from robotcore.deploy.agent import systemd_units as units
from robotcore.deploy.agent.files import Layout, measure_free_space
from robotcore.deploy.agent.releases import ENVIRONMENT, SITE
from robotcore.recording import ring, segments
from tests.robotcore.deploy.agent.sample_releases import NEW, OLD, make_current, put_release
from tests.texts import CheckText

REPORT = """
import json, os, sys
print(json.dumps({"arguments": sys.argv[1:], "folder": os.getcwd(), "here": __file__, "pid": os.getpid()}))
"""
FAILING = "import sys; sys.exit('GPIO busy')"

Systemd = Callable[[str], "subprocess.Popen[str]"]


@pytest.fixture
def systemd(layout: Layout, tmp_path: Path) -> Systemd:
    """Starts the program as the units do."""
    layout.root.mkdir(parents=True)
    units.install_program(layout, rpc.read_agent_sources())
    runtime = tmp_path / "runtime"
    runtime.joinpath("robotcore").mkdir(parents=True)
    environment = {**os.environ, "HOME": str(layout.home), "XDG_RUNTIME_DIR": str(runtime)}

    def start(what: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-I", str(layout.program), what]
        return subprocess.Popen(
            command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace"
        )

    return start


def make_release(layout: Layout, name: str, source: str = REPORT) -> Path:
    """Make a release that this Python can run."""
    folder = put_release(layout, name)
    folder.joinpath(ENVIRONMENT, "bin").mkdir()
    folder.joinpath(ENVIRONMENT, "bin", "python").symlink_to(sys.executable)
    folder.joinpath(SITE, "robotcore", "__main__.py").write_text(source)
    return folder


def test_process_becomes_the_app_in_the_projects_folder(layout: Layout, systemd: Systemd) -> None:
    folder = make_release(layout, OLD)
    for name in ("robotcore", "runpy", "json"):
        folder.joinpath("project", f"{name}.py").write_text("raise ImportError('of the project')")
    make_current(layout, OLD)
    with systemd("run") as process:
        release, line = _lines(process)
    assert release.startswith(f"release {OLD}")
    ran: dict[str, Any] = json.loads(line)
    assert ran["pid"] == process.pid
    assert ran["folder"] == str(folder / "project")
    assert ran["here"] == str(folder / "site" / "robotcore" / "__main__.py"), "the folder of the release, not the link"


@pytest.mark.slow
def test_each_run_records_in_a_file_of_its_own(layout: Layout, systemd: Systemd) -> None:
    make_release(layout, OLD, REPORT + "open(sys.argv[3], 'x').close()\n")
    make_current(layout, OLD)
    for _ in range(3):
        with systemd("run") as process:
            arguments = json.loads(_lines(process)[1])["arguments"]
        assert (process.returncode, arguments[:2], arguments[3]) == (0, ["run", "--record"], "--record-limit")
        assert 0 < int(arguments[4]) < measure_free_space(layout.home)
    assert len(list(layout.recordings.glob("*.mcap"))) == 3


def make_ring_release(layout: Layout) -> None:
    folder = make_release(layout, OLD)
    replace(releases.Release.read(folder), record_last="10min").write(folder)
    make_current(layout, OLD)


def test_a_recording_can_keep_only_the_end_of_the_run(layout: Layout, systemd: Systemd) -> None:
    make_ring_release(layout)
    with systemd("run") as process:
        arguments = json.loads(_lines(process)[1])["arguments"]
    assert (arguments[1], arguments[3:6]) == ("--record", ["--record-last", "10min", "--record-limit"])
    assert 10_000_000 <= int(arguments[6]) <= 500_000_000


def test_the_oldest_recordings_make_room(layout: Layout, systemd: Systemd) -> None:
    make_ring_release(layout)
    layout.recordings.mkdir()
    names = [f"2026-11-21T22-40-{second:02}Z.mcap" for second in range(25)]
    for name in (*names, "mine.mcap"):
        layout.recordings.joinpath(name).touch()
    files.locate_segments(layout.recordings / names[0]).mkdir()
    with systemd("run") as process:
        process.communicate()
    assert {path.name for path in layout.recordings.iterdir()} == {*names[-19:], "mine.mcap"}


def test_the_oldest_recording_is_deleted_even_if_the_clock_jumps(
    layout: Layout, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_ring_release(layout)
    monkeypatch.setattr(service, "KEPT_RECORDINGS", 3)
    release, recorded = releases.Release.read(layout.releases / OLD), []
    for clock in (2_000_000_000, 4_000_000_000, 0, 0, 2_000_000_100):
        monkeypatch.setattr("robotcore.deploy.agent.service.time.time", lambda clock=clock: clock + 0.5)
        path = Path(service._build_record_options(layout, release)[1])
        path.touch()
        recorded.append(path)
        assert sorted(layout.recordings.iterdir()) == recorded[-3:]
    assert recorded[1].name == "2096-10-02T07-06-40Z.mcap"
    assert recorded[2].name == "2096-10-02T07-06-41Z.mcap"


@pytest.mark.parametrize("name", ["2026-13-21T22-40-00Z.mcap", "2026-1-2T22-40-00Z.mcap", "9.mcap"])
def test_files_with_other_names_are_kept(layout: Layout, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    make_ring_release(layout)
    monkeypatch.setattr(service, "KEPT_RECORDINGS", 1)
    layout.recordings.mkdir()
    layout.recordings.joinpath(name).touch()
    service._build_record_options(layout, releases.Release.read(layout.releases / OLD))
    assert [path.name for path in layout.recordings.iterdir()] == [name]


def test_a_ring_needs_room_and_the_app_starts_without_it(layout: Layout, monkeypatch: pytest.MonkeyPatch) -> None:
    make_ring_release(layout)
    monkeypatch.setattr(service, "measure_free_space", lambda _: 15_000_000)
    options = service._build_record_options(layout, releases.Release.read(layout.releases / OLD))
    assert (options[0], options[2:]) == ("--record", ("--record-limit", "7500000"))


def test_limits_and_names_are_those_of_the_recorder(tmp_path: Path) -> None:
    assert service.MIN_RING_BYTES == ring.MIN_LIMIT_BYTES
    assert files.locate_segments(tmp_path / "run.mcap") == segments.locate_segments(tmp_path / "run.mcap")


@pytest.mark.slow
def test_motors_are_stopped_by_the_release_that_ran(layout: Layout, systemd: Systemd, tmp_path: Path) -> None:
    leaves = "import os, sys, pathlib; pathlib.Path.home().joinpath(sys.argv[1] + '.of').write_text(os.getcwd())"
    for name in (OLD, NEW):
        make_release(layout, name, leaves)
    make_current(layout, OLD)
    systemd("run").communicate()
    releases.set_current(layout, NEW)
    with systemd("off") as process:
        assert process.communicate() == ("", "")
    assert layout.home.joinpath("stop.of").read_text() == str(layout.releases / OLD / "project")


def test_failed_stop_is_reported(layout: Layout, systemd: Systemd) -> None:
    make_release(layout, OLD, FAILING)
    make_current(layout, OLD)
    process = systemd("off")
    assert process.communicate()[1] == "robotcore: the motors may still turn: GPIO busy\n\n"
    assert process.returncode == 2


@pytest.mark.parametrize("manifest", ["", "[]", '{"format": 1}', '{"format": 1, "run": 5}'])
def test_damaged_release_is_an_error_with_a_remedy(
    layout: Layout, capsys: pytest.CaptureFixture[str], manifest: str, check_text: CheckText
) -> None:
    put_release(layout, OLD).joinpath("release.json").write_text(manifest)
    make_current(layout, OLD)
    assert service.main(["run"], layout) == 2
    check_text(capsys.readouterr().err)


@pytest.mark.parametrize(
    "lacking, is_unreadable, message, status",
    [
        ("release.json", False, "No such file or directory", 2),
        ("environment/bin/python", False, "No such file or directory", 2),
        ("release.json", True, "Is a directory", 1),
    ],
)
def test_systemd_restarts_an_unreadable_release_but_no_broken_one(
    layout: Layout, systemd: Systemd, lacking: str, is_unreadable: bool, message: str, status: int
) -> None:
    file = make_release(layout, OLD) / lacking
    file.unlink()
    if is_unreadable:
        file.mkdir()  # reading it fails, as on a bad card
    make_current(layout, OLD)
    process = systemd("run")
    assert process.communicate()[1].startswith(f"robotcore: {file}: {message}.")
    assert process.returncode == status, "systemd does not try again after a 2"


def test_robot_without_a_release_has_nothing_to_stop_or_to_check(layout: Layout) -> None:
    layout.root.mkdir(parents=True)
    assert [service.main([command], layout) for command in ("off", "health-check")] == [0, 0]


def test_equal_sources_make_an_equal_program(layout: Layout, systemd: Systemd) -> None:
    before = layout.program.stat()
    units.install_program(layout, rpc.read_agent_sources())
    assert layout.program.stat().st_ino == before.st_ino, "it was not written again"
    units.install_program(layout, {"robotcore/__init__.py": "new"})
    assert zipfile.ZipFile(layout.program).read("robotcore/__init__.py") == b"new"


def _lines(process: subprocess.Popen[str]) -> list[str]:
    said, failed = process.communicate()
    assert not failed
    return said.splitlines()
