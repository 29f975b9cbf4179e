"""A robot to deploy to: a real sshd on loopback for the tests' user, with its own key, home and search path."""

from __future__ import annotations

import getpass
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from robotcore.deploy.host import RobotAddress

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
    """A server for ``ssh -F config robot``. The client has its own key, known hosts and configuration."""

    folder: Path
    """The client's folder."""
    home: Path
    """The robot's home folder."""
    port: int
    pid: int
    others: frozenset[int] = frozenset()
    """The server's processes for connections that other tests keep open."""

    @property
    def address(self) -> RobotAddress:
        return RobotAddress("robot", ssh_config=self.config)

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
    def bin(self) -> Path:
        """The first folder of the robot's search path."""
        return self.home.with_name("bin")

    def connections(self) -> list[int]:
        """Return the server's processes, one for each connection."""
        output = Path(f"/proc/{self.pid}/task/{self.pid}/children").read_text(encoding="ascii")
        return [pid for pid in map(int, output.split()) if pid not in self.others]


_ROBOT = pytest.StashKey["Sshd"]()


@pytest.fixture(scope="session")
def robot(pytestconfig: pytest.Config, tmp_path_factory: pytest.TempPathFactory) -> Sshd:
    """The robot of the whole test run, with everything that a deploy needs."""
    if _ROBOT not in pytestconfig.stash:
        unwind = ExitStack()
        pytestconfig.add_cleanup(unwind.close)
        pytestconfig.stash[_ROBOT] = unwind.enter_context(serving(tmp_path_factory.mktemp("robot") / "sshd"))
    return pytestconfig.stash[_ROBOT]


@pytest.fixture
def sshd(robot: Sshd, tmp_path: Path) -> Sshd:
    """The robot with an empty home, and with a client whose files the test may change."""
    shutil.rmtree(robot.home)
    robot.home.mkdir()
    (folder := tmp_path / "client").mkdir()
    for name in ("key", "key.pub", "known_hosts"):
        shutil.copy(robot.folder / name, folder)
    (folder / "config").write_text(robot.config.read_text().replace(str(robot.folder), str(folder)))
    return replace(robot, folder=folder, others=frozenset(robot.connections()))


def require_programs() -> None:
    """Skip the test on a machine without the programs of an ssh server."""
    if not (SERVER and shutil.which("ssh") and shutil.which("rsync")):
        pytest.skip("needs sshd, ssh and rsync")


@contextmanager
def serving(folder: Path, *more: str, path: str = SYSTEM_PATH) -> Iterator[Sshd]:
    """Run a server with its files in a new folder.

    more: lines of sshd_config.
    path: the search path after ``bin``.
    """
    require_programs()
    if os.geteuid() == 0:
        Path("/run/sshd").mkdir(mode=0o755, exist_ok=True)  # on other systems it exists after the boot
    for name in ("home", "bin"):
        (folder / name).mkdir(parents=True)
    for name in ("host_key", "key"):
        make_key(folder / name)
    (folder / "bin" / "python3").symlink_to(Path(sys.executable).resolve())  # the base Python of the tests
    port, process = _start(folder, "\n".join(more), f"{folder}/bin:{path}".rstrip(":"))
    try:
        yield Sshd(folder, folder / "home", port, process.pid)
    finally:
        process.terminate()
        process.communicate()


def slow_rsync(folder: Path) -> Path:
    """Make a folder with an rsync of 3 MB/s, so that a test can interrupt a transfer."""
    folder.mkdir()
    (folder / "rsync").write_text(f'#!/bin/sh\nexec {shutil.which("rsync")} --bwlimit=3000 "$@"\n', encoding="utf-8")
    (folder / "rsync").chmod(0o755)
    return folder


def make_key(file: Path) -> None:
    """Make a key pair, ``file`` and ``file.pub``."""
    command = ("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", file)
    subprocess.run(command, check=True)


def _start(folder: Path, more: str, path: str) -> tuple[int, subprocess.Popen[str]]:
    """Start the server. If another process has taken the port, try another port."""
    while True:
        with socket.create_server(("127.0.0.1", 0)) as server:
            port: int = server.getsockname()[1]
        known = {"folder": folder, "port": port, "path": path, "more": more, "user": getpass.getuser()}
        (folder / "sshd_config").write_text(SERVER_CONFIG.format(**known), encoding="utf-8")
        (folder / "config").write_text(CLIENT_CONFIG.format(**known), encoding="utf-8")
        key = (folder / "host_key.pub").read_text(encoding="ascii")
        (folder / "known_hosts").write_text(f"[127.0.0.1]:{port} {key}", encoding="ascii")
        process = subprocess.Popen(
            [str(SERVER), "-D", "-e", "-f", folder / "sshd_config"], stderr=subprocess.PIPE, text=True
        )
        assert process.stderr
        output = ""
        for line in process.stderr:
            output += line
            if "Server listening" in line:
                return port, process
        process.communicate()
        if "in use" not in output:
            pytest.skip(f"sshd does not start here: {output}")
