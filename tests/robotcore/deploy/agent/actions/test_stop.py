from __future__ import annotations

import pytest

from robotcore.deploy.agent.actions import start, stop
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.releases import current
from robotcore.deploy.agent.releases.verdict import Verdict
from robotcore.deploy.agent.service import units
from robotcore.deploy.agent.telling import RefusalError
from robotcore.deploy.agent.trial import trial
from robotcore.deploy.agent.trial.trial import Trial
from tests.robotcore.deploy.agent import recorded as at
from tests.robotcore.deploy.agent.released import NEW, OLD, let_run, put
from tests.robotcore.deploy.agent.scripted import Scripted

STOPS = ["stop robotcore.service robotcore-trial.service", "stop robotcore.service", "disable robotcore.service"]

pytestmark = pytest.mark.usefixtures("lingering")


def test_stopped_app_stays_so_after_a_reboot(layout: Layout, systemd: Scripted) -> None:
    put(layout, OLD)
    let_run(layout, OLD)
    units.install(layout)
    systemd.will_tell(at.STOPPED)
    came = stop.act(layout)
    assert (came["release"], came["state"]) == (OLD, "stopped")
    assert systemd.calls[2:] == STOPS
    calls = systemd.folder.joinpath("calls").read_text().splitlines()
    assert calls[calls.index(STOPS[1]) + 1] == "reset-failed robotcore.service", "what was stopped has not failed"


def test_release_on_trial_is_taken_back_and_nothing_is_started(layout: Layout, systemd: Scripted) -> None:
    for name in (OLD, NEW):
        put(layout, name)
    let_run(layout, NEW)
    begun = Trial(NEW, OLD, since="2026-11-21T22:40:03Z")
    units.install(layout)
    begun.begin(layout)
    systemd.will_tell(at.STOPPED)
    stop.act(layout)
    assert (current.name_of(layout), trial.pending(layout)) == (OLD, None)
    assert begun.verdict(layout) == Verdict("stopped", "somebody stopped it", since=begun.since)
    assert not [call for call in systemd.calls[3:] if "start" in call]


def test_robot_that_nothing_was_put_on_stands_already(layout: Layout, systemd: Scripted) -> None:
    assert stop.act(layout)["release"] is None
    assert systemd.calls == []


def test_app_that_does_not_stop_is_told_of(layout: Layout, systemd: Scripted) -> None:
    units.install(layout)
    systemd.fails("stop", at.NO_BUS)
    with pytest.raises(RefusalError, match="loginctl enable-linger"):
        stop.act(layout)


def test_started_app_starts_with_the_robot_too(layout: Layout, systemd: Scripted) -> None:
    put(layout, OLD)
    let_run(layout, OLD)
    systemd.will_tell(at.BACK_STARTS, at.BACK_RUNS)
    assert start.act(layout)["state"] == "running"
    assert systemd.calls == [
        "daemon-reload",
        "enable robotcore.service robotcore-trial.service",
        "start --no-block robotcore.service",
    ]


def test_robot_without_a_release_has_nothing_to_start(layout: Layout) -> None:
    with pytest.raises(RefusalError, match="robotcore deploy push"):
        start.act(layout)
