from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.hardware.firmware import toolchain
from tests.robotcore.hardware.firmware.tools import Tools


@pytest.fixture
def tools(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Tools:
    """A PATH without tools, to which a test adds fake tools."""
    monkeypatch.setattr(toolchain, "AVR_CORE", tmp_path / "nowhere")
    return Tools(tmp_path, monkeypatch)
