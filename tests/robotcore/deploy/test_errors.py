from __future__ import annotations

import getpass
import os
import shutil
import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from threading import Thread

import pytest

from robotcore.deploy import rsync, ssh
from robotcore.deploy.errors import BROKEN, explain_failed_connection
from robotcore.deploy.host import RobotAddress
from robotcore.deploy.robot_answers import EmptyAnswer
from robotcore.deploy.rpc import RobotLink
from robotcore.errors import DeployError
from tests.robotcore.deploy.conftest import AddAction
from tests.robotcore.deploy.sshd import Sshd, make_key, serving
from tests.texts import Raises

WAIT = """
import time
from robotcore.deploy.agent.rpc import report_progress

def act(layout):
    report_progress("waits")
    time.sleep(600)
"""


def connect(server: Sshd | None = None, host: str = "robot") -> None:
    """Connect to a host, and close the connection."""
    with RobotLink(RobotAddress.parse(host), server.config if server else None):
        pass


@contextmanager
def serve_robot(folder: Path, *commands: str) -> Iterator[Sshd]:
    """Serve a robot that has only Python and these commands."""
    with serving(folder, path="") as server:
        for command in commands:
            (server.bin / command).symlink_to(str(shutil.which(command)))
        yield server


def configure(server: Sshd, line: str) -> None:
    """Put a line at the beginning of the client's configuration, where it has precedence."""
    server.config.write_text(f"{line}\n{server.config.read_text()}")


def test_unknown_host_name(raises: Raises) -> None:
    with raises(DeployError, "unknown"):
        connect(host="rover.invalid")


def test_host_without_an_ssh_server(raises: Raises) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with raises(DeployError, "refused", hide=[port]):
        connect(host=f"pi@127.0.0.1:{port}")


def test_host_without_a_route(raises: Raises) -> None:
    with raises(DeployError, "no-route"):
        connect(host="224.0.0.1")


@pytest.mark.slow
def test_host_that_sends_nothing(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.setitem(ssh.MASTER_OPTIONS, "ConnectTimeout", 1)
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        with raises(DeployError, "time-out", hide=[port]):
            connect(host=f"127.0.0.1:{port}")


def test_host_that_closes_the_connection(raises: Raises) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        closing = Thread(target=lambda: server.accept()[0].close())  # noqa: PLW0108  it waits in the thread
        closing.start()
        port = server.getsockname()[1]
        with raises(DeployError, "hung-up", hide=[port]):
            connect(host=f"127.0.0.1:{port}")
        closing.join()


def test_key_that_the_robot_does_not_accept(sshd: Sshd, tmp_path: Path, raises: Raises) -> None:
    make_key(tmp_path / "other")
    (tmp_path / "other").replace(sshd.key)
    with raises(DeployError, "denied", hide=[getpass.getuser()]):
        connect(sshd)


def test_quiet_ssh_configuration_does_not_hide_a_failure(sshd: Sshd) -> None:
    configure(sshd, "LogLevel QUIET")
    sshd.known_hosts.write_text("")
    with pytest.raises(DeployError) as raised:
        connect(sshd)
    assert raised.value.kind == "host-key-unknown"


def test_too_many_keys(tmp_path: Path, raises: Raises) -> None:
    with serving(tmp_path / "sshd", "MaxAuthTries 1") as server:
        make_key(tmp_path / "other")
        configure(server, f"IdentityFile {tmp_path}/other")
        with raises(DeployError, "denied"):
            connect(server)


def test_key_that_other_users_may_read(sshd: Sshd, raises: Raises) -> None:
    sshd.key.chmod(0o644)
    with raises(DeployError, "open-key"):
        connect(sshd)


def test_changed_host_key(sshd: Sshd, raises: Raises) -> None:
    known, _ = sshd.known_hosts.read_text().split(" ", 1)
    sshd.known_hosts.write_text(f"{known} {sshd.key.with_suffix('.pub').read_text()}")
    with raises(DeployError, "host-key-changed", hide=[sshd.port]):
        connect(sshd)


def test_unknown_host_key(sshd: Sshd, raises: Raises) -> None:
    sshd.known_hosts.write_text("")
    with raises(DeployError, "host-key-unknown"):
        connect(sshd)


def test_ssh_configuration_with_an_error(sshd: Sshd, raises: Raises) -> None:
    configure(sshd, "Nonsense yes")
    with raises(DeployError, "configuration"):
        connect(sshd)


@pytest.mark.parametrize("file", ["/etc/passwd", "{key}"])
def test_banner_of_a_robot_does_not_get_into_a_remedy(tmp_path: Path, file: str, raises: Raises) -> None:
    banner = tmp_path / "banner"
    with serving(tmp_path / "sshd", f"Banner {banner}") as server:
        file = file.format(key=server.key)
        banner.write_text(f"Permissions 0644 for '{file}' are too open.\n/etc/x line 1: run this\n")
        make_key(tmp_path / "other")
        (tmp_path / "other").replace(server.key)
        with raises(DeployError, "denied", hide=[getpass.getuser()]):
            connect(server)


@pytest.mark.parametrize("named", ["/etc/passwd", "{home}/.ssh/../.profile", "relative"])
def test_remedy_names_no_file_outside_of_the_users_ssh_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: str
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    line = "Permissions 0644 for '{0}' are too open.\nhi\n"
    refused = explain_failed_connection(RobotAddress.parse("robot"), 255, line.format(named.format(home=tmp_path)))
    assert refused.kind == "ssh-failed"
    accepted = explain_failed_connection(RobotAddress.parse("robot"), 255, line.format(f"{tmp_path}/.ssh/id"))
    assert accepted.kind == "open-key"


def test_text_of_a_disconnect_does_not_get_into_a_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    output = (
        f"Received disconnect from 10.0.0.1 port 22:2: bye\nPermissions 0644 for '{tmp_path}/.ssh/id' are too open.\n"
    )
    assert explain_failed_connection(RobotAddress.parse("robot"), 255, output).kind == "ssh-failed"


def test_missing_ssh_on_this_machine(
    sshd: Sshd, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, raises: Raises
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with raises(DeployError, "no-program"):
        connect(sshd)


def test_missing_rsync_on_this_machine(
    sshd: Sshd, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, raises: Raises
) -> None:
    with RobotLink(RobotAddress.parse("robot"), sshd.config) as link:
        monkeypatch.setenv("PATH", str(tmp_path))
        with raises(DeployError, "no-program"):
            rsync.send(link, tmp_path, "incoming")


def test_missing_rsync_on_the_robot(tmp_path: Path, raises: Raises) -> None:
    with (
        serve_robot(tmp_path / "sshd", "cat") as server,
        RobotLink(RobotAddress.parse("robot"), server.config) as link,
        raises(DeployError, "no-rsync"),
    ):
        rsync.send(link, tmp_path, "incoming")


def test_missing_python_on_the_robot(tmp_path: Path, raises: Raises) -> None:
    with serve_robot(tmp_path / "sshd", "cat") as server, RobotLink(RobotAddress.parse("robot"), server.config) as link:
        (server.bin / "python3").unlink()
        with raises(DeployError, "python"):
            link.call("probe", EmptyAnswer)


def test_disabled_account(tmp_path: Path, raises: Raises) -> None:
    with (
        serving(tmp_path / "sshd", "ForceCommand echo This account is not available; exit 1") as server,
        raises(DeployError, "login-shell-ended", status=1),
    ):
        connect(server)


@pytest.mark.slow
def test_full_disk_of_the_robot(sshd: Sshd, tmp_path: Path, raises: Raises) -> None:
    (folder := tmp_path / "sent").mkdir()
    (folder / "big").write_bytes(os.urandom(1 << 20))
    (full := sshd.home / "robotcore").mkdir()
    mount = ("mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", full)
    if subprocess.run(mount, check=False, capture_output=True).returncode:
        pytest.skip("only root may mount a small disk")
    with ExitStack() as unwind:
        unwind.callback(subprocess.run, ("umount", full), check=True)
        link = unwind.enter_context(RobotLink(RobotAddress.parse("robot"), sshd.config))
        with raises(DeployError, "disk-full"):
            rsync.send(link, folder, "incoming")


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_connection_that_breaks_in_a_call(
    sshd: Sshd, add_action: AddAction, number: signal.Signals, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(ssh.MASTER_OPTIONS, "ServerAliveInterval", 1)
    monkeypatch.setitem(ssh.MASTER_OPTIONS, "ServerAliveCountMax", 1)
    add_action("wait", WAIT)
    connections: list[int] = []

    def break_connection(_notice: object) -> None:
        connections.extend(sshd.connections())
        for pid in connections:
            os.kill(pid, number)

    with (
        RobotLink(RobotAddress.parse("robot"), sshd.config) as link,
        pytest.raises(DeployError) as raised,
    ):
        link.call("wait", EmptyAnswer, on_message=break_connection)
    assert raised.value.kind == BROKEN
    for pid in connections:
        if number is signal.SIGSTOP:
            os.kill(pid, signal.SIGCONT)


@pytest.mark.slow
def test_connection_that_breaks_in_a_transfer(sshd: Sshd, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The transfer is slow, because rsync reports progress only once a second."""
    monkeypatch.setattr(rsync, "COMMON_OPTIONS", (*rsync.COMMON_OPTIONS, "--bwlimit=500k"))
    (folder := tmp_path / "sent").mkdir()
    (folder / "big").write_bytes(os.urandom(1 << 24))
    (sshd.home / "robotcore").mkdir()

    def break_connection(done: int, part: float) -> None:
        for pid in sshd.connections():
            os.kill(pid, signal.SIGKILL)

    with RobotLink(RobotAddress.parse("robot"), sshd.config) as link, pytest.raises(DeployError) as raised:
        rsync.send(link, folder, "incoming", on_progress=break_connection)
    assert raised.value.kind == BROKEN
    assert not (sshd.home / "robotcore" / "incoming" / "big").exists()
