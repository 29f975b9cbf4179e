"""Addresses of robots, and a link in a program at a terminal: questions of ssh, and Ctrl-C."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from robotcore.deploy import ssh
from robotcore.deploy.host import RobotAddress
from robotcore.errors import UsageError
from tests.robotcore.deploy.sshd import Sshd, slow_rsync

HOSTILE = (
    "",
    "-oProxyCommand=touch canary",
    "pi@-oProxyCommand=touch canary",
    "-E@rover",
    "rover;touch canary",
    "rover\n",
    "$(touch canary)",
    "pi@$(touch${IFS}canary)",
    "pi@%h",
    "~root",
    "ro ver",
    "ro\0ver",
    "ssh://rover",
    "rover::canary",
    "rover:",
    "rover:0",
    "rover:65536",
    "rover:22 -oProxyCommand=x",
    "rover:2²",
    "@rover",
    "pi@rover@other",
    "rover.",
    "röver",
    "::1",
    "[::1",
    "[::1%$(touch canary)]",
    "a" * 254,
    "u" * 65 + "@rover",
)


def test_text_with_a_meaning_for_a_shell_or_for_ssh_is_no_host() -> None:
    for text in HOSTILE:
        with pytest.raises(UsageError) as raised:
            pytest.fail(f"{text!r} is {RobotAddress.parse(text)!r}")
        assert raised.value.kind == "invalid-host", text


def test_text_of_a_host_is_that_of_the_user() -> None:
    for text, host in [
        ("rover", RobotAddress("rover")),
        ("pi@rover.local", RobotAddress("rover.local", "pi")),
        ("rover_2:2222", RobotAddress("rover_2", "", 2222)),
        ("pi.zero-2@192.168.1.20:22", RobotAddress("192.168.1.20", "pi.zero-2", 22)),
        ("[::1]", RobotAddress("::1")),
        ("pi@[fe80::1%wlan0]:2222", RobotAddress("fe80::1%wlan0", "pi", 2222)),
    ]:
        assert RobotAddress.parse(text) == host
        assert str(host) == text


ANSWERING_S = 20

CONNECT = """
with RobotLink(RobotAddress("robot", ssh_config=config)) as link:
    print("connected", flush=True)
"""

SEND = """
with RobotLink(RobotAddress("robot", ssh_config=config)) as link:
    try:
        rsync.send(link, folder, "incoming", on_progress=lambda done, part: print("sending", flush=True))
    except KeyboardInterrupt:
        rsync.send(link, folder / "small", "incoming")
        print("interrupted", flush=True)
"""

PROGRAM = """
import os, sys
from pathlib import Path
from robotcore.deploy import rsync, ssh
from robotcore.deploy.host import RobotAddress
from robotcore.deploy.rpc import RobotLink

os.open(os.ttyname(0), os.O_RDWR)  # makes it the terminal of this session
ssh.EXIT_GRACE_S = 600  # nothing is killed
config, ssh.SOCKET_FOLDER, folder = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
"""


class Terminal:
    """A terminal in which a program runs, with methods for a user's input and for its output."""

    def __init__(self, program: subprocess.Popen[bytes], line: int) -> None:
        self.program = program
        self._line = line

    def type(self, text: str) -> None:
        os.write(self._line, text.encode())

    def read_until(self, words: str) -> None:
        """Read the terminal's output until it contains the words."""
        read = b""
        while words.encode() not in read:
            assert select.select([self._line], [], [], ANSWERING_S)[0], read
            read += os.read(self._line, 1 << 16)


@contextmanager
def terminal(program: str, *arguments: str | Path) -> Iterator[Terminal]:
    line, its_end = pty.openpty()
    command = [sys.executable, "-c", PROGRAM + program, *arguments]
    with subprocess.Popen(command, stdin=its_end, stdout=its_end, stderr=its_end, start_new_session=True) as process:
        os.close(its_end)
        try:
            yield Terminal(process, line)
        finally:
            process.kill()
            os.close(line)


def lock_key(sshd: Sshd) -> None:
    """Protect the client's key by a passphrase."""
    command = ("ssh-keygen", "-q", "-p", "-P", "", "-N", "open sesame", "-f", sshd.key)
    subprocess.run(command, check=True)


@pytest.mark.slow
def test_ssh_asks_for_a_host_key_and_a_passphrase(sshd: Sshd, tmp_path: Path) -> None:
    lock_key(sshd)
    sshd.known_hosts.write_text("")
    asking = sshd.config.read_text().replace("BatchMode yes", "").replace("Checking yes", "Checking ask")
    sshd.config.write_text(asking)
    with TemporaryDirectory(dir=ssh.SOCKET_FOLDER) as room, terminal(CONNECT, sshd.config, room, tmp_path) as person:
        person.read_until("(yes/no/[fingerprint])?")
        person.type("yes\n")
        person.read_until("Enter passphrase for key")
        person.type("open sesame\n")
        person.read_until("connected")
        assert person.program.wait(ANSWERING_S) == 0


@pytest.mark.slow
def test_ctrl_c_ends_a_question(sshd: Sshd, tmp_path: Path) -> None:
    lock_key(sshd)
    sshd.config.write_text(sshd.config.read_text().replace("BatchMode yes", ""))
    with TemporaryDirectory(dir=ssh.SOCKET_FOLDER) as room, terminal(CONNECT, sshd.config, room, tmp_path) as person:
        person.read_until("Enter passphrase for key")
        person.type("\x03")
        person.read_until("KeyboardInterrupt")
        assert person.program.wait(ANSWERING_S) == -signal.SIGINT
        assert not list(Path(room).iterdir())


@pytest.fixture
def folder(sshd: Sshd, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that takes four seconds to send."""
    (sshd.home / "robotcore").mkdir()
    monkeypatch.setenv("PATH", str(slow_rsync(tmp_path / "slow")), prepend=os.pathsep)
    (folder := tmp_path / "sent").mkdir()
    (folder / "small").mkdir()
    (folder / "big").write_bytes(os.urandom(12 << 20))
    return folder


@pytest.mark.slow
def test_ctrl_c_ends_a_transfer_and_leaves_no_file(sshd: Sshd, folder: Path) -> None:
    with TemporaryDirectory(dir=ssh.SOCKET_FOLDER) as room, terminal(SEND, sshd.config, room, folder) as person:
        person.read_until("sending")
        [connection] = map(os.pidfd_open, sshd.connections())
        person.type("\x03")
        person.read_until("interrupted")
        assert person.program.wait(ANSWERING_S) == 0
        assert not list(Path(room).iterdir())
        assert select.select([connection], [], [], ANSWERING_S)[0]
        os.close(connection)
    assert not (sshd.home / "robotcore" / "incoming" / "big").exists()


@pytest.mark.slow
def test_connection_ends_if_the_client_is_killed(sshd: Sshd, folder: Path) -> None:
    with TemporaryDirectory(dir=ssh.SOCKET_FOLDER) as room, terminal(SEND, sshd.config, room, folder) as person:
        person.read_until("sending")
        [connection] = map(os.pidfd_open, sshd.connections())
        person.program.send_signal(signal.SIGKILL)
        assert select.select([connection], [], [], ANSWERING_S)[0]
        os.close(connection)
