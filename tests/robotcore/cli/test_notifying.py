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
    """Of systemd's socket, as a service's process is given it."""
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
        heard = [systemd.recv(4096).decode() for _ in range(4)]
    assert heard[:2] == ["READY=1", "WATCHDOG=1"]
    assert heard[2].startswith("STATUS=")
    assert heard[3].splitlines()[::2] == ["STOPPING=1", f"STATUS=error: {answer.json['reason']}"]
    check_text(answer.json["reason"])


@pytest.fixture
def hasty(tmp_path: Path) -> str:
    """The shipped robot, with a watchdog that waits for nothing."""
    file = tmp_path / "hasty.toml"
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


@pytest.mark.parametrize("deed", HANGS.values(), ids=HANGS)
def test_a_service_that_hangs_has_another_status_than_a_safety_stop(
    app_file: AppFile, hasty: str, address: str, deed: str
) -> None:
    """systemd starts what ended with 5 again, and never what ended with 4."""
    command = (sys.executable, "-m", "robotcore", "run", app_file(deed), "--world", "open", "--robot", hasty)
    environment = {**os.environ, "WATCHDOG_PID": ""}
    answer = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert answer.returncode == 5


def test_a_safety_stop_keeps_its_exit_status_in_a_service(cli: Cli, app_file: AppFile, address: str) -> None:
    assert cli("run", app_file("robot.drive.set_velocity(float('nan'), 0.0)"), "--world", "open").status == 4


@pytest.mark.parametrize("deed", ["return Status.FAILURE", "os.mkdir('run.png'); return Status.SUCCESS"])
def test_a_failed_service_has_a_status_that_python_does_not_use(
    cli: Cli, app_file: AppFile, address: str, deed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Python has 1 where an import fails, say of a file that a worn card does not give: such a robot tries again."""
    monkeypatch.chdir(tmp_path)
    assert cli("run", app_file(deed), "--world", "open", "--picture", "run.png").status == FAILED
    assert f"\nRestartPreventExitStatus=2 4 {FAILED}\n" in UNIT_TEXTS[SERVICE]
