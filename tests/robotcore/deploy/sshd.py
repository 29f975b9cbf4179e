"""A robot to deploy to: a real sshd on loopback, as whoever runs the tests, with a key, home and path of its own."""

from __future__ import annotations

import getpass
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

SERVER = shutil.which("sshd", path="/usr/sbin:/usr/local/sbin:/usr/bin")
SYSTEM_PATH = "/usr/local/bin:/usr/bin:/bin"

SERVER_CONFIG = """
ListenAddress 127.0.0.1:{port}
HostKey {folder}/host_key
AuthorizedKeysFile {folder}/key.pub
SetEnv HOME={folder}/home PATH={path}
PidFile none
StrictModes no
UsePAM no
PasswordAuthentication no
KbdInteractiveAuthentication no
PermitRootLogin prohibit-password
PrintMotd no
PrintLastLog no
{more}
"""

CLIENT_CONFIG = """
Host robot
  HostName 127.0.0.1
  Port {port}
  User {user}
  IdentityFile {folder}/key
  IdentitiesOnly yes
  IdentityAgent none
  UserKnownHostsFile {folder}/known_hosts
  GlobalKnownHostsFile /dev/null
  StrictHostKeyChecking yes
  BatchMode yes
"""


@dataclass(frozen=True)
class Sshd:
    """A server that answers to ``ssh -F config robot``.

    ``home`` is where ``~`` is there, ``bin`` the first folder of its search path; `pid` is the server's own.
    """

    folder: Path
    port: int
    pid: int

    @property
    def host(self) -> str:
        return "robot"

    @property
    def config(self) -> Path:
        return self.folder / "config"

    @property
    def known_hosts(self) -> Path:
        return self.folder / "known_hosts"

    @property
    def key(self) -> Path:
        return self.folder / "key"

    @property
    def home(self) -> Path:
        return self.folder / "home"

    @property
    def bin(self) -> Path:
        return self.folder / "bin"

    def connections(self) -> list[int]:
        """Return the processes that serve a connection each."""
        output = Path(f"/proc/{self.pid}/task/{self.pid}/children").read_text(encoding="ascii")
        return [int(pid) for pid in output.split()]


@pytest.fixture
def sshd(tmp_path: Path) -> Iterator[Sshd]:
    """A robot that has all it needs."""
    with serving(tmp_path / "sshd") as server:
        yield server


@contextmanager
def serving(folder: Path, *more: str, path: str = SYSTEM_PATH) -> Iterator[Sshd]:
    """Serve from a folder that is made; ``more`` are lines of sshd_config, ``path`` is searched after ``bin``."""
    if not (SERVER and shutil.which("ssh") and shutil.which("rsync")):
        pytest.skip("needs sshd, ssh and rsync")
    _make_room_for_privileges()
    _furnish(folder)
    port, process = _start(folder, "\n".join(more), f"{folder}/bin:{path}".rstrip(":"))
    try:
        yield Sshd(folder, port, process.pid)
    finally:
        process.terminate()
        process.communicate()


def _furnish(folder: Path) -> None:
    """Make the keys, the home, and a search path with the Python that runs the tests, outside its environment."""
    for name in ("home", "bin"):
        (folder / name).mkdir(parents=True)
    for name in ("host_key", "key"):
        make_key(folder / name)
    (folder / "bin" / "python3").symlink_to(Path(sys.executable).resolve())


def slow_rsync(folder: Path) -> Path:
    """Make a folder with an rsync for the desk that takes its time: 3 MB a second, so that it can be interrupted."""
    folder.mkdir()
    (folder / "rsync").write_text(f'#!/bin/sh\nexec {shutil.which("rsync")} --bwlimit=3000 "$@"\n', encoding="utf-8")
    (folder / "rsync").chmod(0o755)
    return folder


def _make_room_for_privileges() -> None:
    """Make the folder that a server started by root insists on; elsewhere whoever starts the system makes it."""
    if os.geteuid() == 0:
        Path("/run/sshd").mkdir(mode=0o755, exist_ok=True)


def make_key(file: Path, passphrase: str = "") -> None:
    """Make a key pair, ``file`` and ``file.pub``."""
    command = ("ssh-keygen", "-q", "-t", "ed25519", "-N", passphrase, "-f", file)
    subprocess.run(command, check=True)


def _start(folder: Path, more: str, path: str) -> tuple[int, subprocess.Popen[str]]:
    """Start the server; a port that somebody has taken meanwhile is given up for another."""
    while True:
        port = _free_port()
        _configure(folder, port, more, path)
        process = subprocess.Popen(
            [str(SERVER), "-D", "-e", "-f", folder / "sshd_config"], stderr=subprocess.PIPE, text=True
        )
        output = _read_until_listening(process)
        if process.poll() is None:
            return port, process
        process.communicate()
        if "in use" not in output:
            pytest.skip(f"sshd does not start here: {output}")


def _read_until_listening(process: subprocess.Popen[str]) -> str:
    assert process.stderr
    output = ""
    for line in process.stderr:
        output += line
        if "Server listening" in line:
            return output
    process.wait()
    return output


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
        return port


def _configure(folder: Path, port: int, more: str, path: str) -> None:
    known = {"folder": folder, "port": port, "path": path, "more": more, "user": getpass.getuser()}
    (folder / "sshd_config").write_text(SERVER_CONFIG.format(**known), encoding="utf-8")
    (folder / "config").write_text(CLIENT_CONFIG.format(**known), encoding="utf-8")
    key = (folder / "host_key.pub").read_text(encoding="ascii")
    (folder / "known_hosts").write_text(f"[127.0.0.1]:{port} {key}", encoding="ascii")
