from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.deploy import agent as aboard
from robotcore.deploy.agent.system import facts, session
from robotcore.deploy.connection import boot


@pytest.fixture
def lingering(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A robot whose systemd serves whoever runs the tests from boot on; the sources are there, as in a call."""
    folder = tmp_path / "linger"
    folder.mkdir()
    folder.joinpath(session.user()).touch()
    monkeypatch.setattr(facts, "LINGERING", folder)
    for path, text in boot.sources().items():
        monkeypatch.setitem(aboard.sources, path, text)
    return folder
