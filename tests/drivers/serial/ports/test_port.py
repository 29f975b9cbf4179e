from __future__ import annotations

import os
from pathlib import Path

import pytest

from drivers.serial.port import WRITE_TIMEOUT_S, Port
from robotcore.hal.wall_clock import MonotonicClock
from tests.doubles.serial.pty import Pty


def test_what_was_written_is_no_failure_however_long_the_processor_was_away(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock, write = MonotonicClock(), os.write

    def interrupted(file: int, data: bytes) -> int:
        written = write(file, data)
        clock.sleep_until(clock.now() + 1.2 * WRITE_TIMEOUT_S)
        return written

    with Pty(tmp_path) as pty:
        port = Port(str(pty.path), 57600)
        port.open()
        monkeypatch.setattr(os, "write", interrupted)
        port.write(b"m 20 20\r")
        monkeypatch.undo()
        port.close()
        assert pty.heard() == b"m 20 20\r"
