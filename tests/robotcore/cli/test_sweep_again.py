from __future__ import annotations

import os
import re
import signal
from datetime import datetime, timezone
from pathlib import Path

import pytest

from robotcore import RunRequest
from robotcore.errors import Interrupted
from tests.robotcore.cli.conftest import Cli
from tests.texts import CheckText

SHORT = ("sweep", "avoid-obstacles", "--world", "open", "--set", "duration_s=0.2")


@pytest.fixture(autouse=True)
def _enter_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.slow
def test_a_complete_sweep_runs_nothing_and_shows_its_date(
    cli: Cli, requests: list[RunRequest], check_text: CheckText
) -> None:
    first = cli(*SHORT, "--seeds", "1-2")
    done = cli(*SHORT, "--seeds", "1-2")
    assert len(requests) == 2
    assert done.out.endswith(first.out)
    check_text(re.sub(r"\d", "0", done.out.splitlines()[0]))
    assert cli(*SHORT, "--seeds", "1-2", "--fresh").status == 0
    assert len(requests) == 4


@pytest.mark.slow
def test_finished_runs_are_reported_before_the_others(
    cli: Cli, requests: list[RunRequest], check_text: CheckText
) -> None:
    arguments = (*SHORT, "--seeds", "1-3", "--out", "here")
    cli(*arguments)
    file = Path("here/results.jsonl")
    file.write_text("".join(file.read_text().splitlines(keepends=True)[:2]))
    os.utime(file, (0, 10**9))
    date = datetime.fromtimestamp(10**9, tz=timezone.utc).astimezone()
    check_text(cli(*arguments).out.splitlines()[0], hide=[f"{date:%Y-%m-%d %H:%M}"])
    assert len(requests) == 4


@pytest.mark.slow
def test_more_seeds_continue_a_sweep_and_fewer_run_nothing(cli: Cli, requests: list[RunRequest]) -> None:
    cli(*SHORT, "--seeds", "1-2")
    done = cli(*SHORT, "--seeds", "1-3", "--json").json
    assert [request.seed for request in requests] == [1, 2, 3]
    assert (done["runs"], done["done"]) == (3, 3)
    done = cli(*SHORT, "--seeds", "3", "--json").json
    assert (done["runs"], done["done"], done["groups"][0]["runs"], len(requests)) == (1, 1, 1, 3)


@pytest.mark.slow
def test_the_hint_after_an_interrupted_fresh_sweep_leaves_fresh_out(
    cli: Cli, requests: list[RunRequest], monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr("robotcore.sweep.summary.Progress.update", lambda *_, **__: signal.raise_signal(signal.SIGTERM))
    done = cli(*SHORT, "--seeds", "1-3", "--fresh", "--out", "here")
    check_text(done.err)


@pytest.mark.slow
def test_an_interrupt_keeps_finished_runs_and_shows_a_hint(
    cli: Cli, requests: list[RunRequest], monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        if len(requests) == 2:
            raise Interrupted(signal.SIGINT)

    monkeypatch.setattr("robotcore.sweep.summary.Progress.update", interrupted)
    done = cli(*SHORT, "--seeds", "1-5", "--out", "here", "--require", "success>=1")
    assert done.status == 130
    check_text(done.err)
    assert len(Path("here/results.jsonl").read_text().splitlines()) == 2
