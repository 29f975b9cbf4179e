from __future__ import annotations

from robotcore.deploy.agent.actions import releases
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases.verdict import HEALTHY, Verdict
from robotcore.deploy.agent.system import durable
from tests.robotcore.deploy.agent.released import NEW, OLD, let_run, put


def test_a_robot_that_nothing_was_put_on_has_none(layout: Layout) -> None:
    assert releases.act(layout) == {"releases": [], "current": None, "on_trial": None}


def test_the_newest_comes_first_each_with_what_came_of_it(layout: Layout) -> None:
    Verdict(HEALTHY, "it ended with success").write(put(layout, OLD))
    put(layout, NEW)
    let_run(layout, OLD)
    durable.write(layout.trial, f'{{"release": "{NEW}", "previous": "{OLD}"}}')
    told = releases.act(layout)
    assert (told["current"], told["on_trial"]) == (OLD, NEW)
    assert [each["name"] for each in told["releases"]] == [NEW, OLD]
    assert [each["verdict"] for each in told["releases"]] == [None, "healthy"]
    assert told["releases"][1]["app"] == "my 'robot'.py"


def test_a_release_of_another_format_is_told_as_such(layout: Layout) -> None:
    file = put(layout, OLD) / "release.json"
    file.write_text(file.read_text().replace('"format": 1', '"format": 2'))
    (told,) = releases.act(layout)["releases"]
    assert told["name"] == OLD
    assert told["unreadable"] == "release.json has the format 2; this robotcore reads 1"


def test_what_is_no_release_is_none(layout: Layout) -> None:
    put(layout, OLD)
    (layout.releases / "notes").mkdir()
    assert [each["name"] for each in releases.act(layout)["releases"]] == [OLD]
