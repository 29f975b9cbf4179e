from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.hardware.firmware import avr_gcc
from tests.robotcore.hardware.firmware.tools import Tools


@pytest.fixture
def tools(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Tools:
    """Nothing is installed but what a test puts there."""
    monkeypatch.setattr(avr_gcc, "CORE", tmp_path / "nowhere")
    return Tools(tmp_path, monkeypatch)
