"""A robot's folders, in a temporary home."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.deploy.agent.layout import Layout
from tests.robotcore.deploy.agent.scripted import systemd as systemd  # noqa: PLC0414  given on


@pytest.fixture
def layout(tmp_path: Path) -> Layout:
    return Layout(tmp_path / "home with 'quotes' and ü")
