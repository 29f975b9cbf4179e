"""The commands of each page exist, with their options, names and files."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from robotcore.hal.backend import Backend
from tests.docs.command_lines import NOT_CHECKED, find_mistake, parse, split_commands
from tests.docs.listings import list_commands, list_listings, read_pages
from tests.docs.reader_files import write_reader_files

PAGES = read_pages()
SHELLS = {
    page: commands
    for page, text in PAGES.items()
    if (
        commands := [
            words for each in list_listings(text) if each.language == "sh" for words in split_commands(each.text)
        ]
    )
}
CONSOLES = {page: consoles for page, text in PAGES.items() if (consoles := list_commands(text))}
LANGUAGES = {"sh", "console", "python", "toml", "json", "ini", "yaml", "markdown", "text", ""}
"""The languages of listings. Tests run or check those of the first four; the others are outputs, files and pictures."""

UNINSTALLED = {
    "robotcore run avoid-obstacles --backend my-board": "the reader's own package has this backend",
    "robotcore run avoid-obstacles --backend my-board --robot my_board.toml": "the same",
    "robotcore run cautious.py --robot robot.toml --world open": "the reader's own package has this kind of device",
    "robotcore deploy push --skip-checks --offline pi@rover-$n": "the shell replaces $n",
    "robotcore sweep $app": "the shell replaces $app",
}
"""The commands whose names are unknown here, and why. Their tests are those of `robotcore new`."""

RUN_BY = {
    "docs/apps.md": "test_console_listings",
    "docs/index.md": "test_get_started_page",
    "docs/interactive.md": "test_console_listings",
    "docs/manoeuvres.md": "test_console_listings",
    "docs/navigation.md": "test_console_listings",
    "docs/raspberry-pi.md": "test_console_listings",
    "docs/run-from-python.md": "test_console_listings",
    "docs/faults.md": "test_faults_page",
    "docs/recording.md": "test_recording_page",
    "docs/tutorials/bubblerob.md": "test_tutorials",
    "docs/tutorials/green-relay.md": "test_tutorials",
}
"""The pages whose console commands a test runs, and its module."""

NOT_RUN = {"docs/deploy.md": "the commands need a real robot; tests/system/deploy runs them on a machine"}
"""The pages whose console commands no test runs, and why. Their commands are parsed."""


@pytest.mark.parametrize("page", SHELLS)
def test_each_command_of_a_page_is_valid(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Backend, "require_installed", lambda _self: None)  # the reader has the board
    write_reader_files(page, tmp_path)
    monkeypatch.chdir(tmp_path)
    commands = [words for words in SHELLS[page] if not any(" ".join(words).startswith(each) for each in UNINSTALLED)]
    mistakes = {" ".join(words): find_mistake(words) for words in commands}
    assert {command: mistake for command, mistake in mistakes.items() if mistake} == {}


def test_each_console_is_run_or_cannot_be() -> None:
    assert set(CONSOLES) == RUN_BY.keys() | NOT_RUN.keys()
    for page, module in RUN_BY.items():
        source = (Path(__file__).parent / f"{module}.py").read_text(encoding="utf-8")
        assert f'"{Path(page).stem}' in source, (page, module)


@pytest.mark.parametrize("page", NOT_RUN)
def test_commands_that_no_test_runs_are_parsed(page: str) -> None:
    for console in CONSOLES[page]:
        (words,) = split_commands(console.command)
        assert parse(words[1:])


def test_each_listing_has_a_known_language() -> None:
    assert {listing.language for text in PAGES.values() for listing in list_listings(text)} == LANGUAGES


def test_the_commands_of_a_service_are_valid() -> None:
    services = [each.text for text in PAGES.values() for each in list_listings(text) if each.language == "ini"]
    commands = re.findall(r"^Exec\w+=\S*/robotcore (.*)$", "\n".join(services), re.MULTILINE)
    assert [parse(words.split())[0] for words in commands] == ["run", "stop"]


def test_the_tables_have_no_stale_entry() -> None:
    typed = [" ".join(words) for commands in SHELLS.values() for words in commands]
    assert [each for each in UNINSTALLED if not any(command.startswith(each) for command in typed)] == []
    programs = {words[0] for commands in SHELLS.values() for words in commands}
    assert set(NOT_CHECKED) - programs == set()


@pytest.mark.parametrize(
    "command, mistake",
    [
        ("robotcore run green-search --sped 7", "No such option"),
        ("robotcore run green-search --backend bullet", "unknown backend"),
        ("robotcore run green-search --robot no_robot.toml", "no_robot.toml"),
        ("robotcore run green-search --world aren", "unknown world"),
        ("robotcore run green-search --set hue=no-hue", "hue"),
        ("robotcore run green-search --fault 'camera drop=2'", "drop"),
        ("robotcore run no_app.py", "no_app.py"),
        ("robotcore sweep green-search --world aren", "unknown world"),
        ("robotcore calibrate wheels --robot rover", "unknown"),
        ("robotcore export rover --seed x", "integer"),
        ("robotcore replay no.mcap", "no.mcap"),
        ("make demon", "no target demon"),
        ("python -m benchmarks.no_such", "no module"),
        ("python -m benchmarks.run_endings --exhaust 50", "no option --exhaust"),
        ("python no_script.py", "no_script.py"),
        ('pip install -e ".[reccord]"', "no extra reccord"),
        ("robocore run green-search", "unknown program"),
    ],
)
def test_a_wrong_command_is_found(command: str, mistake: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (words,) = split_commands(command)
    assert mistake in find_mistake(words)


def test_commands_are_split_as_a_shell_does() -> None:
    shell = (
        'robotcore new a && cd a  # a comment\nfor n in $(seq 2); do\n  A=1 robotcore check "b c" > d || echo no\ndone'
    )
    assert list(split_commands(shell)) == [
        ["robotcore", "new", "a"],
        ["cd", "a"],
        ["robotcore", "check", "b c"],
        ["echo", "no"],
    ]
