from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from robotcore import Outcome, RunRequest
from robotcore.cli.sweep import command
from robotcore.errors import BackendError, BackendMissingError
from robotcore.sweep import Record, Sweep
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


def test_json_is_one_line(cli: Cli, requests: list[RunRequest]) -> None:
    done = cli(*SHORT, "--seeds", "1-2", "--json", "--out", "here")
    assert (done.status, done.err) == (0, "")
    assert (done.json["runs"], done.json["done"], done.json["failing"], done.json["missed"]) == (2, 2, 0, [])
    assert done.json["directory"] == "here"
    (group,) = done.json["groups"]
    assert (group["backend"], group["world"], group["verified"], group["contacts"]) == ("kinematic", "open", None, 0)
    assert (group["verified_share"], group["success_share"]) == (None, 1.0)


@pytest.mark.slow
def test_json_repeats_the_request(cli: Cli, requests: list[RunRequest]) -> None:
    arguments = ("sweep", "green-search", "--timeout", "0.1", "--judge", "green-search", "--world", "open,arena")
    done = cli(*arguments, "--seeds", "5,1-2", "--json").json
    assert (done["app"], done["judge"], done["seeds"]) == ("green-search", "green-search", "5,1-2")
    assert (done["backends"], done["worlds"]) == (["kinematic"], ["open", "arena"])


@pytest.mark.slow
def test_the_page_explains_every_key(cli: Cli, requests: list[RunRequest]) -> None:
    done = cli(*SHORT, "--seeds", "1", "--json").json
    guide = (Path(__file__).parents[3] / "docs" / "sweeps.md").read_text(encoding="utf-8")
    assert [key for key in (*done, *done["groups"][0]) if f"`{key}`" not in guide] == []


@pytest.mark.slow
def test_json_numbers_have_six_decimals(cli: Cli, requests: list[RunRequest], monkeypatch: pytest.MonkeyPatch) -> None:
    times = iter((26.4, 26.500000000000007))
    monkeypatch.setattr(
        "tests.robotcore.cli.conftest.perform", lambda request: _perform_with_time(request, next(times))
    )
    (group,) = cli(*SHORT, "--seeds", "1-2", "--json").json["groups"]
    assert group["median_time_s"] == 26.45
    assert group["verified_95"] == [0.34238, 1.0]


def _perform_with_time(request: RunRequest, time: float) -> RunOutput:
    ended = perform(request)
    result = replace(ended.record.result, sim_time_s=time, verified=True)
    return RunOutput(replace(ended.record, result=result))


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
        r"  \d+ × timeout, not done after 0\.1 s, in 'search'\n"
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


def test_a_missing_backend_has_exit_status_3(cli: Cli, monkeypatch: pytest.MonkeyPatch, check_text: CheckText) -> None:
    def rehearse(_: object) -> None:
        raise BackendMissingError("no simulator")

    monkeypatch.setattr("robotcore.sweep.preflight.preflight", rehearse)
    answer = cli(*SHORT)
    assert (answer.status, answer.out) == (3, "")
    check_text(answer.err)


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


def test_every_field_of_a_request_has_an_option_except_gui_and_realtime() -> None:
    fields = set(RunRequest.__dataclass_fields__) - {"gui", "realtime"}
    plural = {"backend": "backends", "world": "worlds", "seed": "seeds"}
    assert {plural.get(name, name) for name in fields} <= {parameter.name for parameter in command.params}


@pytest.mark.slow
def test_a_report_has_all_results_of_the_folder(
    cli: Cli, requests: list[RunRequest], monkeypatch: pytest.MonkeyPatch
) -> None:
    done = _replace_report(monkeypatch)
    assert cli(*SHORT, "--seeds", "1-2", "--out", "here", "--report", "page").out.endswith(
        "The report: page/index.html\n"
    )
    records, directory, pictures = done["given"]
    assert [record.result.seed for record in records] == [1, 2]
    assert (directory, pictures, done["worlds"]) == (Path("page"), Path("here"), [])
    line = "robotcore sweep mark-green --world open --set duration_s=0.2 --seeds 1-2 --out here --report page"
    assert done["command"] == line


@pytest.mark.slow
def test_a_report_has_the_requirements(cli: Cli, requests: list[RunRequest], monkeypatch: pytest.MonkeyPatch) -> None:
    done = _replace_report(monkeypatch)
    cli(*SHORT, "--seeds", "1", "--out", "here", "--report", "page", "--require", "contacts<=0")
    assert [str(each) for each in done["requirements"]] == ["contacts<=0"]


def test_a_report_that_cannot_be_written_is_reported_before_the_sweep(
    cli: Cli, requests: list[RunRequest], monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    _replace_report(monkeypatch, BackendMissingError("no Jinja2"))
    answer = cli(*SHORT, "--report", "page")
    assert (answer.status, answer.out) == (3, "")
    check_text(answer.err)
    assert requests == []


def test_a_report_into_an_impossible_folder_is_refused_before_the_sweep(
    cli: Cli, requests: list[RunRequest], check_text: CheckText
) -> None:
    done = cli(*SHORT, "--report", "/proc/nope")
    assert (done.status, requests) == (2, [])
    check_text(done.err)


def _replace_report(monkeypatch: pytest.MonkeyPatch, error: Exception | None = None) -> dict[str, Any]:
    """Replace the module that writes reports. Return a dict that receives the arguments of ``write_report``."""
    done: dict[str, Any] = {}

    def require_writable(directory: Path) -> None:
        if error:
            raise error

    def write_report(records: Any, directory: Path, pictures: Path, **more: Any) -> Path:
        done.update(given=(records, directory, pictures), **more)
        return directory / "index.html"

    report = ModuleType("robotcore.sweep.report")
    vars(report).update(require_writable=require_writable, write_report=write_report)
    monkeypatch.setitem(sys.modules, report.__name__, report)
    return done
