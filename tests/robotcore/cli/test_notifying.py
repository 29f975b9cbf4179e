from __future__ import annotations

import os
from pathlib import Path
from socket import AF_UNIX, SOCK_DGRAM, socket

import pytest

from tests.robotcore.cli.conftest import AppFile, Cli


@pytest.fixture
def address(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Of systemd's socket, as a service's process is given it."""
    path = str(tmp_path / "notify")
    told = {"NOTIFY_SOCKET": path, "WATCHDOG_USEC": "60000000", "WATCHDOG_PID": str(os.getpid())}
    for name, value in told.items():
        monkeypatch.setenv(name, value)
    return path


def test_a_run_tells_systemd_and_hides_it_from_what_the_app_starts(cli: Cli, app_file: AppFile, address: str) -> None:
    app = app_file("raise ValueError(sorted(each for each in os.environ if each.startswith(('NOTIFY', 'WATCHDOG'))))")
    with socket(AF_UNIX, SOCK_DGRAM) as systemd:
        systemd.bind(address)
        told = cli("run", app, "--world", "open", "--json")
        heard = [systemd.recv(4096).decode() for _ in range(4)]
    assert told.json["reason"] == "Odd raised ValueError: []"
    assert heard[:2] == ["READY=1", "WATCHDOG=1"]
    assert heard[2].startswith("STATUS=")
    assert heard[3] == "STOPPING=1\nSTATUS=error: Odd raised ValueError: []"
