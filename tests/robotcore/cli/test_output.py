from __future__ import annotations

import ast
import shlex
import subprocess
import sys
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Group
from rich.text import Text

import robotcore.cli
from robotcore.cli.command_classes import write_result
from robotcore.cli.output import write, write_failure, write_finding, write_line, write_table
from robotcore.hal.check_finding import Finding
from robotcore.runtime.result import Outcome, RunResult
from tests.robotcore.cli.conftest import AppFile, Cli

HOSTILE = "\x1b]0;title\x07\x1b[2J\x9b31m\u202e\nerror: forged"
SHOWN = r"\x1b]0;title\x07\x1b[2J\x9b31m\u202e"

CLI = Path(robotcore.cli.__file__).parent


def require_harmless(written: str) -> None:
    assert all(each.isprintable() or each == "\n" for each in written)
    assert SHOWN in written
    assert not any(line.startswith("error: forged") for line in written.splitlines())


def test_json_comes_before_the_notes(monkeypatch: pytest.MonkeyPatch) -> None:
    written = StringIO()
    monkeypatch.setattr("sys.stdout", written)
    monkeypatch.setattr("sys.stderr", written)
    write_result(RunResult("an-app", "mock", "rover", None, None, Outcome.SUCCESS, 0, notes=["a note"]), as_json=True)
    answer, *notes = written.getvalue().splitlines()
    assert (answer[0], notes) == ("{", ["note: a note"])


def test_control_characters_of_a_line_are_escaped(capsys: pytest.CaptureFixture[str]) -> None:
    write_line(f"The picture: {HOSTILE}")
    written = capsys.readouterr().out
    require_harmless(written)
    assert written.count("\n") == 1


@pytest.mark.parametrize("is_terminal", [False, True])
def test_colours_in_a_text_are_escaped(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *, is_terminal: bool
) -> None:
    monkeypatch.setattr("click.utils.should_strip_ansi", lambda *_: not is_terminal)
    write_failure(f"\x1b[31m{HOSTILE}")
    written = capsys.readouterr().err
    assert written.count("\x1b") == (3 if is_terminal else 0)
    assert f"\\x1b[31m{SHOWN}\n  error: forged\n" in written


def test_texts_of_rich_are_escaped(capsys: pytest.CaptureFixture[str]) -> None:
    words = HOSTILE.partition("\n")[0].replace("\x07", "")
    write(Group(Text(words, "red"), words))
    written = capsys.readouterr().out
    assert written.count(SHOWN.replace(r"\x07", "")) == 2
    assert all(each.isprintable() or each == "\n" for each in written)


def test_cells_of_a_table_are_escaped_and_keep_their_lines(capsys: pytest.CaptureFixture[str]) -> None:
    write_table(("name", "what"), [("one", HOSTILE)])
    written = capsys.readouterr().out
    require_harmless(written)
    assert [line.split() for line in written.splitlines()][-1] == ["error:", "forged"]


def test_the_texts_of_a_finding_are_escaped(capsys: pytest.CaptureFixture[str]) -> None:
    write_finding(Finding.error("nose", HOSTILE, HOSTILE, kind="hostile"))
    require_harmless(capsys.readouterr().out)


def test_a_long_subject_is_separate_from_its_message(capsys: pytest.CaptureFixture[str]) -> None:
    write_finding(Finding.ok("proximity sensors", "detect a box", kind="sensors-work"))
    assert "proximity sensors detect a box" in capsys.readouterr().out


def test_an_error_of_an_app_cannot_forge_a_line(cli: Cli, app_file: AppFile) -> None:
    result = cli("run", app_file(f"raise ValueError({HOSTILE!r})"))
    assert result.status == 5
    require_harmless(result.err)
    assert all(each.isprintable() or each == "\n" for each in result.out)


def test_every_command_writes_with_the_module_output() -> None:
    """`robotcore deploy` has its own terminal lines."""
    files = [file for file in CLI.rglob("*.py") if file.name != "output.py"]
    calls = [node for file in files for node in ast.walk(ast.parse(file.read_text())) if isinstance(node, ast.Call)]
    assert calls
    assert not {"click.echo", "click.secho", "print"} & {ast.unparse(call.func) for call in calls}


@pytest.mark.slow
@pytest.mark.posix("a shell closes the streams")
@pytest.mark.parametrize("closed", ["<&- >&-", ">&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize("command", ["doctor", "sweep avoid-obstacles --seeds 1-2 --fresh --timeout 1 --out out"])
def test_a_command_works_with_closed_standard_streams(closed: str, command: str, tmp_path: Path) -> None:
    line = f"{shlex.quote(sys.executable)} -m robotcore {command} {closed}"
    ended = subprocess.run(
        ["/bin/sh", "-c", line], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60
    )
    assert "Traceback" not in ended.stderr
    assert ended.returncode == 0, ended.stderr
