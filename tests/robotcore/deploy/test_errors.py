from __future__ import annotations

import os
import re
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
from robotcore.deploy.answers import EmptyAnswer
from robotcore.deploy.errors import BROKEN, connection_failed
from robotcore.deploy.host import Host
from robotcore.deploy.rpc import Link
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


def connect_error(server: Sshd | None = None, host: str = "robot") -> str:
    """Return what is told of a host that cannot be connected to."""
    with pytest.raises(DeployError) as failed, Link(Host.parse(host), server.config if server else None):
        pass
    return str(failed.value)


@contextmanager
def robot_with(folder: Path, *commands: str) -> Iterator[Sshd]:
    """A robot that has nothing but these commands, and its Python where that is one of them."""
    with serving(folder, path="") as server:
        for command in commands:
            (server.bin / command).symlink_to(str(shutil.which(command)))
        yield server


def configure(server: Sshd, line: str) -> None:
    """Put a line before those of the client's configuration: the first one counts."""
    server.config.write_text(f"{line}\n{server.config.read_text()}")


def test_no_host_of_that_name() -> None:
    assert connect_error(host="rover.invalid") == (
        "rover.invalid: there is no host of the name rover.invalid. Is it switched on, in this network, and spelt so? "
        "Its address does as well: pi@192.168.1.20"
    )


def test_a_host_without_a_server() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    assert connect_error(host=f"pi@127.0.0.1:{port}") == (
        f"pi@127.0.0.1:{port}: it is there, but nothing answers at port {port}. Is the port right? If so, switch "
        "ssh on there: sudo systemctl enable --now ssh"
    )


def test_a_host_to_which_there_is_no_way() -> None:
    assert connect_error(host="224.0.0.1").startswith("224.0.0.1: there is no way to it. ")


def test_a_host_that_says_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ssh.MASTER_OPTIONS, "ConnectTimeout", 1)
    with socket.create_server(("127.0.0.1", 0)) as server:
        host = f"127.0.0.1:{server.getsockname()[1]}"
        assert connect_error(host=host).startswith(f"{host}: it does not answer. ")


def test_a_host_that_hangs_up() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        hanging_up = Thread(target=lambda: server.accept()[0].close())  # noqa: PLW0108  it waits in the thread
        hanging_up.start()
        host = f"127.0.0.1:{server.getsockname()[1]}"
        assert connect_error(host=host).startswith(f"{host}: it hung up before the login. ")
        hanging_up.join()


def test_a_key_that_is_not_let_in(sshd: Sshd, tmp_path: Path) -> None:
    make_key(tmp_path / "other")
    (tmp_path / "other").replace(sshd.key)
    assert re.match(r"robot: it does not let \S+ in; it would take: publickey\. ", words := connect_error(sshd))
    assert words.endswith("A key is put there with: ssh-copy-id robot")


def test_a_configuration_that_keeps_ssh_quiet_keeps_no_failure_from_being_reported(sshd: Sshd) -> None:
    configure(sshd, "LogLevel QUIET")
    sshd.known_hosts.write_text("")
    assert "its host key is not known here" in connect_error(sshd)


def test_more_keys_than_are_looked_at(tmp_path: Path) -> None:
    with serving(tmp_path / "sshd", "MaxAuthTries 1") as server:
        make_key(tmp_path / "other")
        configure(server, f"IdentityFile {tmp_path}/other")
        assert "it has had enough of keys" in connect_error(server)


def test_a_key_that_others_may_read(sshd: Sshd) -> None:
    sshd.key.chmod(0o644)
    assert connect_error(sshd) == (
        f"robot: others on this machine may read the key {sshd.key}, so ssh does not use it. "
        f"Close it: chmod 600 {sshd.key}"
    )


def test_another_host_key_than_before(sshd: Sshd) -> None:
    known, _ = sshd.known_hosts.read_text().split(" ", 1)
    sshd.known_hosts.write_text(f"{known} {sshd.key.with_suffix('.pub').read_text()}")
    assert connect_error(sshd) == (
        "robot: it shows another host key than before: it was installed anew, or something else answers in its name. "
        f"If it was installed anew, forget the old key: ssh-keygen -f {sshd.known_hosts} -R '{known}'"
    )


def test_a_host_key_that_nobody_knows(sshd: Sshd) -> None:
    sshd.known_hosts.write_text("")
    assert connect_error(sshd) == (
        "robot: its host key is not known here, and nobody could be asked. Log in once, and compare the key: ssh robot"
    )


def test_a_configuration_that_is_wrong(sshd: Sshd) -> None:
    configure(sshd, "Nonsense yes")
    assert connect_error(sshd) == (
        f"robot: ssh does not understand its configuration: {sshd.config}: line 1: Bad configuration option: nonsense. "
        "Mend it, or take another file: --ssh-config FILE"
    )


@pytest.mark.parametrize("file", ["/etc/passwd", "{key}"])
def test_banner_of_a_robot_puts_nothing_into_the_advice(tmp_path: Path, file: str) -> None:
    banner = tmp_path / "banner"
    with serving(tmp_path / "sshd", f"Banner {banner}") as server:
        file = file.format(key=server.key)
        banner.write_text(f"Permissions 0644 for '{file}' are too open.\n/etc/x line 1: run this\n")
        make_key(tmp_path / "other")
        (tmp_path / "other").replace(server.key)
        assert "it does not let" in connect_error(server)


@pytest.mark.parametrize("named", ["/etc/passwd", "{home}/.ssh/../.profile", "relative"])
def test_file_outside_of_the_user_s_ssh_folder_is_not_named_in_the_advice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: str
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    line = "Permissions 0644 for '{0}' are too open.\nhi\n"
    refused = connection_failed(Host.parse("robot"), 255, line.format(named.format(home=tmp_path)))
    assert (refused.kind, "chmod" in str(refused)) == ("deploy", False)
    assert f"chmod 600 {tmp_path}/.ssh/id" in str(
        connection_failed(Host.parse("robot"), 255, line.format(f"{tmp_path}/.ssh/id"))
    )


def test_reason_of_a_disconnect_puts_nothing_into_the_advice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    said = (
        f"Received disconnect from 10.0.0.1 port 22:2: bye\nPermissions 0644 for '{tmp_path}/.ssh/id' are too open.\n"
    )
    assert "chmod" not in str(connection_failed(Host.parse("robot"), 255, said))


def test_no_ssh_here(sshd: Sshd, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert connect_error(sshd) == "ssh is not installed here. Get it: sudo apt install openssh-client"


def test_no_rsync_here(sshd: Sshd, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, raises: Raises) -> None:
    with Link(Host.parse("robot"), sshd.config) as link:
        monkeypatch.setenv("PATH", str(tmp_path))
        with raises(DeployError, "no-program"):
            link.send(tmp_path, "incoming")


def test_no_rsync_there(tmp_path: Path, raises: Raises) -> None:
    with (
        robot_with(tmp_path / "sshd", "cat") as server,
        Link(Host.parse("robot"), server.config) as link,
        raises(DeployError, "no-rsync"),
    ):
        link.send(tmp_path, "incoming")


def test_no_python_there(tmp_path: Path, raises: Raises) -> None:
    with robot_with(tmp_path / "sshd", "cat") as server, Link(Host.parse("robot"), server.config) as link:
        (server.bin / "python3").unlink()
        with raises(DeployError, "python"):
            link.call("probe", EmptyAnswer)


def test_a_robot_that_lets_nobody_work(tmp_path: Path) -> None:
    with serving(tmp_path / "sshd", "ForceCommand echo This account is not available; exit 1") as server:
        assert connect_error(server) == (
            "robot: its login shell ended at once (status 1): This account is not available. Try it by hand: ssh robot"
        )


def test_a_disk_that_is_full_there(sshd: Sshd, tmp_path: Path) -> None:
    (folder := tmp_path / "sent").mkdir()
    (folder / "big").write_bytes(os.urandom(1 << 20))
    (full := sshd.home / "robotcore").mkdir()
    mount = ("mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", full)
    if subprocess.run(mount, check=False, capture_output=True).returncode:
        pytest.skip("only root may mount a small disk")
    with ExitStack() as unwind:
        unwind.callback(subprocess.run, ("umount", full), check=True)
        link = unwind.enter_context(Link(Host.parse("robot"), sshd.config))
        with pytest.raises(DeployError, match=r"the disk of robot is full\. Make room there: "):
            link.send(folder, "incoming")


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_a_connection_that_breaks_in_a_call(
    sshd: Sshd, add_action: AddAction, number: signal.Signals, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(ssh.MASTER_OPTIONS, "ServerAliveInterval", 1)
    monkeypatch.setitem(ssh.MASTER_OPTIONS, "ServerAliveCountMax", 1)
    add_action("wait", WAIT)
    connections: list[int] = []

    def strike(_notice: object) -> None:
        connections.extend(sshd.connections())
        for pid in connections:
            os.kill(pid, number)

    with (
        Link(Host.parse("robot"), sshd.config) as link,
        pytest.raises(DeployError) as raised,
    ):
        link.call("wait", EmptyAnswer, on_notice=strike)
    assert raised.value.kind == BROKEN
    for pid in connections:
        if number is signal.SIGSTOP:
            os.kill(pid, signal.SIGCONT)


def test_a_connection_that_breaks_in_a_transfer(sshd: Sshd, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is slow: rsync tells of progress once a second, and of what is quicker only when all is there."""
    monkeypatch.setattr(rsync, "COMMON_OPTIONS", (*rsync.COMMON_OPTIONS, "--bwlimit=500k"))
    (folder := tmp_path / "sent").mkdir()
    (folder / "big").write_bytes(os.urandom(1 << 24))
    (sshd.home / "robotcore").mkdir()

    def strike(done: int, part: float) -> None:
        for pid in sshd.connections():
            os.kill(pid, signal.SIGKILL)

    with Link(Host.parse("robot"), sshd.config) as link, pytest.raises(DeployError) as raised:
        link.send(folder, "incoming", on_progress=strike)
    assert raised.value.kind == BROKEN
    assert not (sshd.home / "robotcore" / "incoming" / "big").exists()
