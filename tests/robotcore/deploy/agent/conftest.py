"""A robot's folders, in a temporary home."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from robotcore.deploy import agent, rpc
from robotcore.deploy.agent import robot_facts
from robotcore.deploy.agent.files import Layout
from tests.robotcore.deploy.agent.systemd_double import systemd as systemd  # noqa: PLC0414  a fixture


@pytest.fixture
def layout(tmp_path: Path) -> Layout:
    return Layout(tmp_path / "home with 'quotes' and ü")


@pytest.fixture
def lingering(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of lingering users of a robot with rsync and lingering on. The agent's sources are set, as in a call.

    A program without effect replaces rsync.
    """
    programs = tmp_path / "programs"
    programs.mkdir()
    (programs / "rsync").write_text("#!/bin/sh\n")
    (programs / "rsync").chmod(0o755)
    monkeypatch.setenv("PATH", f"{programs}:{os.environ['PATH']}")
    folder = tmp_path / "linger"
    folder.mkdir()
    folder.joinpath(robot_facts.read_user()).touch()
    monkeypatch.setattr(robot_facts, "LINGER_FOLDER", folder)
    for path, text in rpc.read_agent_sources().items():
        monkeypatch.setitem(agent.sources, path, text)
    return folder
