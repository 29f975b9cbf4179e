from __future__ import annotations

import json
from importlib.metadata import EntryPoint
from typing import Any

import pytest

from robotcore import plugins as registry
from robotcore.description import read_shipped
from tests.robotcore.cli.conftest import Cli
from tests.texts import CheckText


def test_a_missing_backend_is_listed_with_the_command_that_installs_it(
    cli: Cli, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr("drivers.kinematic.backend.KinematicBackend.modules", ("no_such_simulator",))
    kinematic = next(each for each in cli("backends", "--json").json if each["name"] == "kinematic")
    assert kinematic["installed"] is False
    assert kinematic["remedy"] in cli("backends").out
    check_text(kinematic["remedy"])


def test_a_broken_plugin_does_not_hide_the_others(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    broken = EntryPoint("broken", "no_such_package:Thing", "")
    points = {group: {**registry._points(group), "broken": broken} for group in (registry.BACKENDS, registry.APPS)}
    monkeypatch.setattr("robotcore.plugins._points", points.get)
    for name, other in (("backends", "kinematic"), ("apps", "green-search")):
        answer = cli(name)
        assert answer.status == 0
        assert other in answer.out
        assert "no_such_package" in answer.out


ROWS: dict[tuple[str, str], dict[str, Any]] = {
    ("apps", "mark-green"): {"needs": ["camera", "display"], "milestones": ["search", "seen"]},
    ("backends", "kinematic"): {"installed": True, "remedy": None},
    ("robots", "lookout"): {"devices": ["eye", "screen"], "drives": False},
    ("apps", "bump-and-turn"): {"needs": ["bumper", "drive"], "milestones": ["drive", "back", "turn"]},
    ("apps", "follow-line"): {"needs": ["drive", "line_sensor"], "milestones": ["follow", "search"]},
    ("apps", "pan-search"): {
        "needs": ["camera", "drive", "pan", "range"],
        "milestones": ["look", "explore", "approach", "arrived"],
    },
    ("worlds", "clutter"): {"floor_m": [4.0, 4.0], "obstacles": 12, "targets": 1},
}


@pytest.mark.parametrize("command, name", ROWS)
def test_a_row_describes_its_object(cli: Cli, command: str, name: str) -> None:
    (row,) = (row for row in cli(command, "--json").json if row["name"] == name)
    assert {key: row[key] for key in ROWS[command, name]} == ROWS[command, name]
    assert row["summary"]


def test_an_app_is_listed_with_its_settings(cli: Cli) -> None:
    (search,) = (app for app in cli("apps", "--json").json if app["name"] == "green-search")
    assert search["milestones"] == ["search", "seen", "approach", "arrived"]
    assert {"name": "speed_m_s", "type": "float", "default": 0.25} in search["settings"]


@pytest.mark.parametrize("name", ["apps", "backends", "faults", "robots", "worlds"])
def test_a_table_has_the_rows_of_the_json(cli: Cli, name: str) -> None:
    names = [each["name"] for each in json.loads(cli(name, "--json").out)]
    table = cli(name).out.splitlines()
    for each in names:
        assert sum(line.startswith(f"{each} ") for line in table) == names.count(each)


@pytest.mark.parametrize("kind, name, misspelt", [("robot", "rover", "rovr"), ("world", "arena", "aren")])
def test_list_prints_the_file_of_a_robot_or_a_world_to_copy_it(
    cli: Cli, check_text: CheckText, kind: str, name: str, misspelt: str
) -> None:
    command = f"{kind}s"
    assert cli(command, name).out == read_shipped(name, kind)
    assert cli(command, name, "--json").status == 2
    unknown = cli(command, misspelt)
    assert unknown.status == 2
    check_text(unknown.err)
