"""The client: an ssh key, an ssh configuration, and commands in a project's folder."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from tests.system import needs, wheels
from tests.system.deploy.machine import USER, Machine
from tests.system.speed import scaled

HOST = "rover"
"""The alias of the robot in the ssh configuration."""

COMMAND_S = 240.0
"""The time limit of a command on the reference machine, in s."""

BUILD_TOOLS = ("hatchling>=1.21",)
"""The build tool of packages. If it were not installed, pip would download it for each push."""

CONFIG = """\
Host {host}
  HostName {address}
  User {user}
  IdentityFile "{folder}/key"
  IdentitiesOnly yes
  UserKnownHostsFile "{folder}/known_hosts"
  StrictHostKeyChecking yes
"""


@dataclass(frozen=True)
class Client:
    """A folder with the user's key, the robot's host key, and an ssh configuration that names both."""

    folder: Path

    @classmethod
    def of(cls, folder: Path, machine: Machine) -> Client:
        """Make a key, and install it on the robot. The robot may be switched off."""
        client = cls(folder)
        make = ["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-C", "client", "-f", str(folder / "key")]
        subprocess.run(make, check=True)
        host_key = machine.root.joinpath("etc/ssh/ssh_host_ed25519_key.pub").read_text()
        folder.joinpath("known_hosts").write_text(f"{machine.address} {host_key}")
        text = CONFIG.format(host=HOST, address=machine.address, user=USER, folder=folder)
        client.config.write_text(text)
        _authorise(machine, folder.joinpath("key.pub").read_text())
        return client

    @property
    def config(self) -> Path:
        return self.folder / "ssh_config"

    def install(self, project: Path) -> None:
        """Install a user's package with a driver, and the build tool."""
        wheels.install(self._site, [str(project)], "--no-deps")
        wheels.install(self._site, BUILD_TOOLS)

    def ssh(self, command: str) -> str:
        """Run a command on the robot by ssh, without robotcore; return its output."""
        ssh = ["ssh", "-F", str(self.config), HOST, command]
        done = subprocess.run(ssh, capture_output=True, text=True, check=True, timeout=scaled(COMMAND_S))
        return done.stdout

    def rsync(self, folder: Path, there: str) -> None:
        """Send a folder into the user's home by rsync, without robotcore."""
        ssh = shlex.join(["ssh", "-F", str(self.config)])
        subprocess.run(["rsync", "--archive", "--compress", "-e", ssh, f"{folder}/", f"{HOST}:{there}/"], check=True)

    def command(self, *arguments: str) -> list[str]:
        """Return the command line of ``robotcore`` with these arguments."""
        return [sys.executable, "-m", "robotcore", *arguments]

    def deploy(self, action: str, *arguments: str, project: Path | None = None) -> subprocess.CompletedProcess[str]:
        """Run ``robotcore deploy COMMAND rover …`` in a project's folder."""
        return self.run("deploy", action, HOST, *arguments, "--ssh-config", str(self.config), project=project)

    def run(self, *arguments: str, project: Path | None = None) -> subprocess.CompletedProcess[str]:
        """Run a command of robotcore."""
        return subprocess.run(
            self.command(*arguments),
            cwd=project or self.folder,
            env=self.environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
            timeout=scaled(COMMAND_S),
        )

    def build_command(self, action: str, *arguments: str) -> list[str]:
        """Return the command line of `deploy`."""
        return self.command("deploy", action, HOST, *arguments, "--ssh-config", str(self.config))

    @property
    def environment(self) -> dict[str, str]:
        """The variables by which Python finds this checkout's robotcore and the installed packages."""
        packages = os.pathsep.join(map(str, (needs.ROOT, self._site)))
        return {**os.environ, "PYTHONPATH": packages, "NO_COLOR": "1", "COLUMNS": "160"}

    @property
    def _site(self) -> Path:
        return self.folder / "site"


def _authorise(machine: Machine, public: str) -> None:
    folder = machine.home / ".ssh"
    folder.mkdir(mode=0o700)
    folder.joinpath("authorized_keys").write_text(public)
    owner = machine.home.stat()
    for path in (folder, *folder.iterdir()):
        shutil.chown(path, owner.st_uid, owner.st_gid)
