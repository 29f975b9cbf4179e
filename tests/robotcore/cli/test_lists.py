from __future__ import annotations

import json
from importlib.metadata import EntryPoint

import pytest

from robotcore import plugins as registry
from tests.robotcore.cli.conftest import Cli
from tests.texts import CheckText


def test_backends_lists_the_capabilities(cli: Cli) -> None:
    backends = {backend["name"]: backend for backend in cli("backends", "--json").json}
    assert backends["kinematic"]["installed"] is True
    assert backends["kinematic"]["remedy"] is None
    assert set(backends["kinematic"]["vouches_for"]) >= {"contacts", "lockstep", "pose"}


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


def test_apps_have_needs_settings_and_milestones(cli: Cli) -> None:
    apps = {app["name"]: app for app in cli("apps", "--json").json}
    search = apps["green-search"]
    assert search["needs"] == ["camera", "drive", "range"]
    assert search["milestones"] == ["search", "seen", "approach", "arrived"]
    assert {"name": "speed_m_s", "type": "float", "default": 0.25} in search["settings"]
    assert search["summary"].endswith(".")


def test_robots_have_devices(cli: Cli) -> None:
    robots = {robot["name"]: robot for robot in cli("robots", "--json").json}
    assert robots["lookout"]["devices"] == ["eye", "screen"]
    assert (robots["lookout"]["drives"], robots["rover"]["drives"]) == (False, True)


def test_worlds_have_a_size_and_objects(cli: Cli) -> None:
    worlds = {world["name"]: world for world in cli("worlds", "--json").json}
    assert worlds["open"]["floor_m"] == [6.0, 6.0]
    assert (worlds["clutter"]["obstacles"], worlds["clutter"]["targets"]) == (12, 1)


@pytest.mark.parametrize("name", ["apps", "backends", "faults", "robots", "worlds"])
def test_a_table_has_the_rows_of_the_json(cli: Cli, name: str) -> None:
    names = [each["name"] for each in json.loads(cli(name, "--json").out)]
    table = cli(name).out.splitlines()
    for each in names:
        assert sum(line.startswith(f"{each} ") for line in table) == names.count(each)
