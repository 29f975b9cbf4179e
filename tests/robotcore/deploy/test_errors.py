from __future__ import annotations

import getpass
import os
import shutil
import signal
import socket
from collections.abc import Callable
from pathlib import Path
from threading import Thread

import pytest

from robotcore.deploy import rsync, ssh
from robotcore.deploy.errors import BROKEN, explain_failed_connection, explain_failed_transfer
from robotcore.deploy.host import RobotAddress
from robotcore.deploy.robot_answers import EmptyAnswer
from robotcore.deploy.rpc import RobotLink
from robotcore.errors import DeployError
from tests.robotcore.deploy.conftest import WAIT, AddAction
from tests.robotcore.deploy.sshd import Sshd, make_key, serving
from tests.texts import CheckText, Raises


def connect(server: Sshd | None = None, host: str = "robot") -> None:
    """Connect to a host, and close the connection."""
    with RobotLink(server.address if server else RobotAddress.parse(host)):
        pass


def configure(server: Sshd, line: str) -> None:
    """Put a line at the beginning of the client's configuration, where it has precedence."""
    server.config.write_text(f"{line}\n{server.config.read_text()}")


@pytest.mark.parametrize(
    "host, kind", [("rover.invalid", "unknown-host"), ("224.0.0.1", "no-route"), ("pi@127.0.0.1:1", "refused")]
)
def test_host_that_ssh_does_not_reach(host: str, kind: str, raises: Raises) -> None:
    with raises(DeployError, kind):
        connect(host=host)


@pytest.mark.slow
def test_host_that_sends_nothing(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.setitem(ssh.MASTER_OPTIONS, "ConnectTimeout", 1)
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        with raises(DeployError, "no-ssh", hide=[port]):
            connect(host=f"127.0.0.1:{port}")


def test_host_that_closes_the_connection(raises: Raises) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        closing = Thread(target=lambda: server.accept()[0].close())  # noqa: PLW0108  it waits in the thread
        closing.start()
        port = server.getsockname()[1]
        with raises(DeployError, "hung-up", hide=[port]):
            connect(host=f"127.0.0.1:{port}")
        closing.join()


def use_another_key(server: Sshd) -> None:
    make_key(server.folder / "other")
    (server.folder / "other").replace(server.key)


def use_the_key_as_host_key(server: Sshd) -> None:
    known, _ = server.known_hosts.read_text().split(" ", 1)
    server.known_hosts.write_text(f"{known} {server.key.with_suffix('.pub').read_text()}")


def forget_host(server: Sshd) -> None:
    configure(server, "LogLevel QUIET")  # does not hide the reason
    server.known_hosts.write_text("")


@pytest.mark.parametrize(
    "prepare, kind",
    [
        (use_another_key, "denied"),
        (lambda server: server.key.chmod(0o644), "open-key"),
        (use_the_key_as_host_key, "host-key-changed"),
        (forget_host, "host-key-unknown"),
        (lambda server: configure(server, "Nonsense yes"), "configuration"),
    ],
    ids=["denied", "open-key", "host-key-changed", "host-key-unknown", "configuration"],
)
def test_failed_login_is_explained(sshd: Sshd, prepare: Callable[[Sshd], None], kind: str, raises: Raises) -> None:
    prepare(sshd)
    with raises(DeployError, kind, hide=[f"login of {getpass.getuser()}", sshd.port]):
        connect(sshd)


def test_too_many_keys(tmp_path: Path, raises: Raises) -> None:
    with serving(tmp_path / "sshd", "MaxAuthTries 1") as server:
        make_key(tmp_path / "other")
        configure(server, f"IdentityFile {tmp_path}/other")
        with raises(DeployError, "denied"):
            connect(server)


@pytest.mark.parametrize("file", ["/etc/passwd", "{key}"])
def test_banner_of_a_robot_does_not_get_into_a_remedy(tmp_path: Path, file: str, raises: Raises) -> None:
    banner = tmp_path / "banner"
    with serving(tmp_path / "sshd", f"Banner {banner}") as server:
        file = file.format(key=server.key)
        banner.write_text(f"Permissions 0644 for '{file}' are too open.\n/etc/x line 1: run this\n")
        use_another_key(server)
        with raises(DeployError, "denied", hide=[f"login of {getpass.getuser()}"]):
            connect(server)


@pytest.mark.parametrize("named", ["/etc/passwd", "{home}/.ssh/../.profile", "relative"])
def test_remedy_names_no_file_outside_of_the_users_ssh_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: str
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    line = "Permissions 0644 for '{0}' are too open.\nhi\n"
    refused = explain_failed_connection(RobotAddress.parse("robot"), 255, line.format(named.format(home=tmp_path)))
    assert refused.kind == "ssh-failed"
    line = line.format(f"{tmp_path}/.ssh/id")
    assert explain_failed_connection(RobotAddress.parse("robot"), 255, line).kind == "open-key"
    of_robot = f"Received disconnect from 10.0.0.1 port 22:2: bye\n{line}"
    assert explain_failed_connection(RobotAddress.parse("robot"), 255, of_robot).kind == "ssh-failed"


def test_missing_programs_on_this_machine(
    sshd: Sshd, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, raises: Raises
) -> None:
    with RobotLink(sshd.address) as link:
        monkeypatch.setenv("PATH", str(tmp_path))
        with raises(DeployError, "no-program"):
            rsync.send(link, tmp_path, "incoming")
        with raises(DeployError, "no-program"):
            connect(sshd)


def test_missing_programs_on_the_robot(tmp_path: Path, raises: Raises) -> None:
    with serving(tmp_path / "sshd", path="") as server:
        (server.bin / "cat").symlink_to(str(shutil.which("cat")))
        (server.bin / "python3").unlink()
        with RobotLink(server.address) as link:
            with raises(DeployError, "python"):
                link.call("probe", EmptyAnswer)
            with raises(DeployError, "no-rsync"):
                rsync.send(link, tmp_path, "incoming")


@pytest.mark.parametrize(
    "output, kind",
    [
        ("rsync: write failed: No space left on device (28)", "disk-full"),
        ("rsync: --info: unknown option", "old-rsync"),
        ("rsync: something new", "rsync-failed"),
    ],
)
def test_failed_transfer_is_explained(output: str, kind: str, check_text: CheckText) -> None:
    error = explain_failed_transfer(RobotAddress("robot"), 11, f"{output}\nrsync error (code 11)\n", "robot")
    assert error.kind == kind
    check_text(error)


def test_disabled_account(tmp_path: Path, raises: Raises) -> None:
    with (
        serving(tmp_path / "sshd", "ForceCommand echo This account is not available; exit 1") as server,
        raises(DeployError, "login-shell-ended", status=1),
    ):
        connect(server)


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
        RobotLink(sshd.address) as link,
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

    with RobotLink(sshd.address) as link, pytest.raises(DeployError) as raised:
        rsync.send(link, folder, "incoming", on_progress=break_connection)
    assert raised.value.kind == BROKEN
    assert not (sshd.home / "robotcore" / "incoming" / "big").exists()
