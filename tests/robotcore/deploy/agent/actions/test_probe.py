from __future__ import annotations

import platform
from pathlib import Path

import pytest

from robotcore.deploy.agent.actions import probe
from robotcore.deploy.agent.environment import environments, pip
from robotcore.deploy.agent.environment.environments import Recipe
from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.system import facts, needs, session
from robotcore.deploy.agent.telling import RefusalError, say
from tests.robotcore.deploy.agent.released import OLD, let_run, put


def test_a_robot_tells_what_it_is(layout: Layout) -> None:
    told = probe.act(layout)
    assert (told["python"], told["machine"], told["bits"]) == (platform.python_version(), platform.machine(), 64)
    assert told["free_bytes"] > 0
    assert told["release"] is None
    assert not layout.root.exists()


def test_the_release_that_runs_is_told(layout: Layout) -> None:
    put(layout, OLD)
    let_run(layout, OLD)
    assert probe.act(layout)["release"] == OLD


def test_it_is_told_whether_what_is_required_is_there(layout: Layout) -> None:
    assert not probe.act(layout)["has_environment"]
    environments.make(layout, Recipe.of([]), OLD, pip.Need(), say)
    assert probe.act(layout)["has_environment"]
    assert not probe.act(layout, requirements=["numpy"])["has_environment"]


def test_a_poor_machine_tells_all_the_same(layout: Layout, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    told = probe.act(layout)
    assert not any(told[name] for name in ("has_rsync", "has_user_manager", "reads_journal"))


@pytest.fixture
def poor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine without any of what a deploy needs, on which nobody may change that."""
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(facts, "LINGERING", tmp_path)
    monkeypatch.setattr(facts, "bits", lambda: 32)
    monkeypatch.setattr(facts, "has_venv", lambda: False)
    monkeypatch.setattr(session, "user", lambda: "pi")


@pytest.mark.usefixtures("poor")
def test_a_push_is_refused_with_all_that_is_missing_and_what_to_do(layout: Layout) -> None:
    with pytest.raises(RefusalError) as refused:
        probe.act(layout, is_push=True)
    for fault in ("is a 32-bit system", "no rsync", "python3-venv is missing", "nothing of pi's runs"):
        assert fault in refused.value.fault
    for remedy in ("apt install rsync", "apt install python3-venv", "sudo loginctl enable-linger pi"):
        assert remedy in refused.value.remedy
    assert refused.value.kind == "architecture"


@pytest.mark.usefixtures("poor")
def test_an_environment_that_is_there_needs_no_venv(layout: Layout) -> None:
    environments.make(layout, Recipe.of([]), OLD, pip.Need(), say)
    with pytest.raises(RefusalError) as refused:
        probe.act(layout, is_push=True)
    assert "venv" not in str(refused.value)


@pytest.mark.usefixtures("poor")
def test_lingering_is_turned_on_where_that_is_allowed(tmp_path: Path) -> None:
    loginctl = tmp_path / "loginctl"
    loginctl.write_text(f'#!/bin/sh\necho "$@" > "{tmp_path}/told"; : > "{tmp_path}/pi"\n')
    loginctl.chmod(0o755)
    assert needs.lingers()
    assert (tmp_path / "told").read_text() == "--no-ask-password enable-linger\n"
