from __future__ import annotations

import os
import subprocess
import sys
from importlib import resources
from pathlib import Path
from socket import AF_UNIX, SOCK_DGRAM, socket

import pytest

from robotcore.deploy.agent.systemd_units import SERVICE, UNIT_TEXTS
from robotcore.deploy.systemd_notify import FAILED
from tests.robotcore.cli.conftest import AppFile, Cli
from tests.texts import CheckText


@pytest.fixture
def address(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Set the environment of a systemd service, and return the address of its socket."""
    path = str(tmp_path / "notify")
    answer = {"NOTIFY_SOCKET": path, "WATCHDOG_USEC": "60000000", "WATCHDOG_PID": str(os.getpid())}
    for name, value in answer.items():
        monkeypatch.setenv(name, value)
    return path


def test_a_run_notifies_systemd_and_hides_the_socket_from_the_app(
    cli: Cli, app_file: AppFile, address: str, check_text: CheckText
) -> None:
    app = app_file("raise ValueError(sorted(each for each in os.environ if each.startswith(('NOTIFY', 'WATCHDOG'))))")
    with socket(AF_UNIX, SOCK_DGRAM) as systemd:
        systemd.bind(address)
        answer = cli("run", app, "--world", "open", "--json")
        messages = [systemd.recv(4096).decode() for _ in range(4)]
    assert messages[:2] == ["READY=1", "WATCHDOG=1"]
    assert messages[2].startswith("STATUS=")
    assert messages[3].splitlines()[::2] == ["STOPPING=1", f"STATUS=error: {answer.json['reason']}"]
    check_text(answer.json["reason"])


@pytest.fixture
def short_watchdog(tmp_path: Path) -> str:
    """Write the shipped robot's file with a watchdog of 0.2 s."""
    file = tmp_path / "short_watchdog.toml"
    shipped = resources.files("robotcore.description").joinpath("robots", "rover.toml").read_text(encoding="utf-8")
    file.write_text(shipped.replace("[safety]\n", "[safety]\nwatchdog_s = 0.2\n"))
    return str(file)


HANGS = {
    "and comes back": "while True: pass",
    "for good": """
            while True:
                try:
                    while True: pass
                except BaseException: pass
""",
}


@pytest.mark.slow
@pytest.mark.parametrize("step", HANGS.values(), ids=HANGS)
def test_hanging_service_exits_with_status_5(app_file: AppFile, short_watchdog: str, address: str, step: str) -> None:
    """systemd restarts a service after status 5, and does not after status 4."""
    command = (sys.executable, "-m", "robotcore", "run", app_file(step), "--world", "open", "--robot", short_watchdog)
    environment = {**os.environ, "WATCHDOG_PID": ""}
    answer = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert answer.returncode == 5


def test_a_safety_stop_keeps_its_exit_status_in_a_service(cli: Cli, app_file: AppFile, address: str) -> None:
    assert cli("run", app_file("robot.drive.set_velocity(float('nan'), 0.0)"), "--world", "open").status == 4


@pytest.mark.parametrize("step", ["return Status.FAILURE", "os.mkdir('run.png'); return Status.SUCCESS"])
def test_a_failed_service_has_a_status_that_python_does_not_use(
    cli: Cli, app_file: AppFile, address: str, step: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Python exits with 1 if an import fails, for example from a worn SD card. systemd then restarts the service."""
    monkeypatch.chdir(tmp_path)
    assert cli("run", app_file(step), "--world", "open", "--picture", "run.png").status == FAILED
    assert f"\nRestartPreventExitStatus=2 4 {FAILED}\n" in UNIT_TEXTS[SERVICE]
