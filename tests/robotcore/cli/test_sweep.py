from __future__ import annotations

import errno
import json
import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import replace
from html import unescape
from pathlib import Path
from unittest.mock import Mock

import pytest

from robotcore import Outcome, RunRequest
from robotcore.cli.sweep import command
from robotcore.errors import BackendError
from robotcore.sweep import Record, Sweep
from robotcore.sweep.results_file import Journal
from robotcore.sweep.single_run import RunOutput, perform
from tests.robotcore.cli.conftest import Cli
from tests.texts import CheckText

SHORT = ("sweep", "mark-green", "--world", "open", "--set", "duration_s=0.2")


@pytest.fixture(autouse=True)
def _enter_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.slow
def test_every_combination_is_run_and_reported(cli: Cli, requests: list[RunRequest]) -> None:
    done = cli("sweep", "mark-green", "--world", "open,arena", "--seeds", "1,3-4", "--set", "duration_s=0.2")
    assert done.status == 0
    assert {(request.world, request.seed) for request in requests} == {
        (w, s) for w in ("open", "arena") for s in (1, 3, 4)
    }
    rows = [line.split() for line in done.out.splitlines() if line.startswith("kinematic")]
    assert [row[1:] for row in rows] == [[name, "?/3", "0", "0.2", "s", "0.2", "s"] for name in ("arena", "open")]
    assert done.err == ""


@pytest.mark.slow
def test_json_is_one_line_with_the_request_and_each_documented_key(
    cli: Cli, requests: list[RunRequest], monkeypatch: pytest.MonkeyPatch
) -> None:
    def perform_verified(request: RunRequest) -> RunOutput:
        assert request.seed
        ended = perform(request)
        result = replace(ended.record.result, sim_time_s=20 + request.seed / 3, verified=True)
        return RunOutput(replace(ended.record, result=result))

    monkeypatch.setattr("tests.robotcore.cli.conftest.perform", perform_verified)
    done = cli(*SHORT, "--judge", "green-search", "--seeds", "5,1-2", "--json", "--out", "here")
    assert (done.status, done.err) == (0, "")
    (group,) = done.json["groups"]
    guide = (Path(__file__).parents[3] / "docs" / "sweeps.md").read_text(encoding="utf-8")
    assert [key for key in (*done.json, *group) if f"`{key}`" not in guide] == []
    expected = {"app": "mark-green", "judge": "green-search", "seeds": "5,1-2", "backends": ["kinematic"]}
    counts = {"worlds": ["open"], "runs": 3, "done": 3, "failing": 0, "missed": [], "directory": "here"}
    assert done.json | expected | counts == done.json
    assert (group["backend"], group["world"], group["verified"], group["contacts"]) == ("kinematic", "open", 3, 0)
    assert group | {"success_share": 1.0, "verified_95": [0.438503, 1.0], "median_time_s": 20.666667} == group


@pytest.mark.slow
def test_a_failing_engine_is_reported_with_the_finished_runs(
    cli: Cli, requests: list[RunRequest], monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    def perform_one(_: object, sweep: Sweep, missing: Iterable[RunRequest]) -> Iterator[RunOutput]:
        yield perform(next(iter(missing)))
        raise BackendError("the scheduler is gone")

    monkeypatch.setattr("robotcore.sweep.engine.LocalEngine.perform", perform_one)
    arguments = (*SHORT, "--seeds", "1-2", "--require", "success>=1")
    done = cli(*arguments, "--out", "here", "--json")
    assert (done.json["error"], done.json["done"], done.json["runs"]) == ("the scheduler is gone", 1, 2)
    assert (done.status, done.json["exit_status"], done.json["missed"]) == (3, 3, [])
    check_text(done.err)
    done = cli(*arguments, "--out", "there", "--report", "page")
    assert done.status == 3
    assert "\nkinematic  open        ?/1 " in done.out
    assert "success>=1" not in done.out
    assert not Path("page").exists()


@pytest.mark.slow
def test_the_folder_has_the_record_of_each_run(cli: Cli, requests: list[RunRequest]) -> None:
    cli("sweep", "green-search", "--timeout", "0.6", "--seeds", "5", "--world", "open", "--out", "here")
    (record,) = map(Record.from_json, Path("here/results.jsonl").read_text().splitlines())
    assert record.result.outcome is Outcome.TIMEOUT
    assert record.command == "robotcore run green-search --world open --seed 5 --timeout 0.6"
    assert record.path
    assert [time for time, _, _ in record.path] == [0.0, 0.5]
    assert record.picture
    assert Path("here", record.picture).read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_failing_runs_are_reported_by_reason_with_a_command_and_all_of_them_by_a_file(
    cli: Cli, requests: list[RunRequest]
) -> None:
    done = cli("sweep", "green-search", "--timeout", "0.1", "--seeds", "1-22", "--world", "open", "--out", "here")
    assert done.status == 0
    repeats = r"robotcore run green-search --world open --seed \d+ --timeout 0\.1"
    assert re.search(
        r"  \d+ × timeout, not done after 0\.1 s, in state 'search'\n"
        rf"    in open on kinematic: seeds [\d, ]+ and \d+ more\n    {repeats}\n",
        done.out,
    )
    assert "\n  all failing runs: here/failures.csv\n" in done.out


@pytest.mark.slow
def test_a_missed_requirement_has_exit_status_1_with_the_value_and_the_bound(
    cli: Cli, requests: list[RunRequest], check_text: CheckText
) -> None:
    arguments = ("sweep", "green-search", "--timeout", "0.1", "--seeds", "1-2", "--world", "open")
    done = cli(*arguments, "--require", "verified>=0.5", "--require", "contacts<=0")
    assert done.status == 1
    check_text(done.err)
    done = cli(*arguments, "--require", "contacts<=0", "--require", "verified>=0")
    assert done.status == 0
    check_text(done.out.splitlines()[-1])


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments, kind",
    [
        (["green-search", "--backend", ","], "usage"),
        (["green-search", "--require", "verified"], "bad-requirement"),
        (["green-search", "--jobs", "0"], "usage"),
        (["green-search", "--jobs", "a"], "usage"),
        (["green-search", "--jobs", "2", "--cluster", "tcp://lab:8786"], "conflicting-options"),
        (["green-search", "--jobs", "2", "--backend", "coppeliasim"], "backend-serves-one"),
        (["green-search", "--out", ""], "usage"),
        (["green-search", "--report", ""], "usage"),
        (["green-serch", "--report", "new/page"], "unknown-app"),
        (["green-search", "--jobs", "40000"], "too-many-jobs"),
        (["green-search", "--wall-timeout", "nan"], "usage"),
    ],
)
def test_a_wrong_sweep_is_refused_before_the_first_run(
    cli: Cli, requests: list[RunRequest], arguments: list[str], kind: str, check_text: CheckText
) -> None:
    done = cli("sweep", *arguments, "--json")
    assert (done.status, requests, list(Path().iterdir())) == (2, [], [])
    assert done.json["kind"] == kind
    check_text(done.err)
    assert len(done.err.splitlines()) <= 2


@pytest.mark.parametrize("backend, at_a_time", [("coppeliasim", 1), ("kinematic,vrep", 1), ("kinematic", 7)])
def test_an_exclusive_simulator_has_one_run_at_a_time(
    cli: Cli, monkeypatch: pytest.MonkeyPatch, backend: str, at_a_time: int, check_text: CheckText
) -> None:
    given: list[int] = []

    def engine(jobs: int, _: object) -> None:
        given.append(jobs)
        raise BackendError("enough")

    monkeypatch.setattr("robotcore.sweep.engine.count_cores", lambda: 7)
    monkeypatch.setattr("robotcore.sweep.engine.LocalEngine", engine)
    check_text(cli(*SHORT, "--backend", backend).err)
    assert given == [at_a_time]


@pytest.mark.slow
def test_ctrl_c_in_a_terminal_stops_at_once(tmp_path: Path) -> None:
    app = tmp_path / "slow.py"
    app.write_text(
        "from threading import Event\nfrom robotcore import Behaviour, Role, Status\n"
        "class Slow(Behaviour):\n    needs = frozenset({Role.DRIVE})\n    def step(self, robot):\n"
        f"        open({str(tmp_path / 'begun')!r}, 'a').write('x')\n        Event().wait(100)\n"
        "        return Status.RUNNING\n"
    )
    os.mkfifo(tmp_path / "begun")
    arguments = [sys.executable, "-m", "robotcore", "sweep", str(app), "--jobs", "1", "--json"]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert (tmp_path / "begun").read_text() == "x"
        process.send_signal(signal.SIGINT)
        out, err = process.communicate()
    assert process.returncode == -signal.SIGINT
    assert (json.loads(out)["done"], json.loads(out)["exit_status"]) == (0, 130)
    assert err == "interrupted by SIGINT: 0 of 20 runs are saved; the same command resumes the sweep.\n"


def test_every_field_of_a_request_has_an_option_except_those_of_a_watched_run() -> None:
    fields = set(RunRequest.__dataclass_fields__) - {
        "gui",
        "realtime",
        "has_real_time_priority",
        "has_operator",
        "has_separate_motors",
    }
    plural = {"backend": "backends", "world": "worlds", "seed": "seeds"}
    assert {plural.get(name, name) for name in fields} <= {parameter.name for parameter in command.params}


@pytest.mark.slow
def test_a_report_has_all_results_of_the_folder_and_the_requirements(cli: Cli, requests: list[RunRequest]) -> None:
    arguments = (*SHORT, "--seeds", "1-2", "--out", "here", "--report", "page", "--require", "contacts<=0")
    assert cli(*arguments).out.endswith("The report: page/index.html\n")
    page = re.sub("<[^>]*>", "", Path("page/index.html").read_text(encoding="utf-8"))
    words = (shlex.join(["robotcore", *arguments]), "Seeds1-2", "contacts<=0")
    assert [text for text in words if text not in unescape(page)] == []


@pytest.mark.slow
@pytest.mark.parametrize("options", [(), ("--json",)], ids=["text", "json"])
def test_a_report_that_does_not_fit_on_the_disk_is_reported_after_the_results(
    cli: Cli, requests: list[RunRequest], monkeypatch: pytest.MonkeyPatch, options: tuple[str], check_text: CheckText
) -> None:
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    monkeypatch.setattr("robotcore.sweep.report.replace_text", Mock(side_effect=full))
    arguments = (*SHORT, "--seeds", "1", "--out", "here", "--report", "new/page", "--require", "contacts<=0")
    done = cli(*arguments, *options)
    assert (done.status, Path("new").exists()) == (2, False)
    check_text(done.err)
    if options:
        assert (done.json["done"], done.json["kind"], done.json["exit_status"]) == (1, "unusable-folder", 2)
    else:
        assert done.out.endswith("The results: here\n\nMet in every group: contacts<=0\n")


@pytest.mark.slow
def test_a_disk_that_fills_during_the_runs_is_reported_after_the_results(
    cli: Cli, requests: list[RunRequest], monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    def append(journal: Journal, line: str) -> None:
        if len(requests) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        append_line(journal, line)

    append_line = Journal.append
    monkeypatch.setattr(Journal, "append", append)
    done = cli(*SHORT, "--seeds", "1-3", "--out", "here", "--report", "page")
    assert (done.status, len(requests), Path("page").exists()) == (2, 2, False)
    assert "\nkinematic  open        ?/1 " in done.out
    check_text(done.err)


@pytest.mark.parametrize(
    "options",
    [
        ("--report", "r.xml", "--junit", "r.xml"),
        ("--out", "r.xml", "--junit", "sub/../r.xml"),
        ("--report", "r.svg", "--badge", "r.svg"),
        ("--out", "r.svg", "--badge", "r.svg"),
    ],
    ids=["report-junit", "out-junit", "report-badge", "out-badge"],
)
def test_equal_outputs_are_refused_before_the_sweep(
    cli: Cli, requests: list[RunRequest], options: tuple[str, ...], check_text: CheckText
) -> None:
    Path("sub").mkdir()
    done = cli(*SHORT, *options, "--json")
    assert (done.status, done.json["kind"], requests) == (2, "same-output", [])
    assert [each.name for each in Path().iterdir()] == ["sub"]
    check_text(done.err)


@pytest.mark.slow
def test_the_report_may_be_in_the_folder_of_the_results(cli: Cli, requests: list[RunRequest]) -> None:
    assert cli(*SHORT, "--seeds", "1", "--out", "here", "--report", "here").status == 0
    assert {"results.jsonl", "index.html"} <= {each.name for each in Path("here").iterdir()}


def test_a_report_into_an_impossible_folder_is_refused_before_the_sweep(
    cli: Cli, requests: list[RunRequest], check_text: CheckText
) -> None:
    done = cli(*SHORT, "--report", "/proc/nope")
    assert (done.status, requests) == (2, [])
    check_text(done.err)
