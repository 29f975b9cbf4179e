from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from tests.robotcore.safety.guardian.doubles import END_S, Running, Start


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    runs: list[Running] = []

    def start(app: str, *manner: str) -> Running:
        runs.append(running := Running(app, tmp_path / f"diary-{len(runs)}", *manner))
        return running

    yield start
    for running in runs:
        with suppress(ProcessLookupError, PermissionError):  # macOS permits no signal to a group that is gone
            os.killpg(running.process.pid, signal.SIGKILL)
        running.process.communicate(timeout=END_S)
