"""The desk: whoever sits there has a key, an ssh configuration, and types commands in a project's folder."""

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
"""What the ssh configuration calls the target."""

COMMAND_S = 240.0
"""Of a command, on the reference machine: a hang."""

BUILT_WITH = ("hatchling>=1.21",)
"""What builds packages; else pip would fetch it for each push."""

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
class Desk:
    """A folder with a key that the target knows, the target's own, and an ssh configuration that tells of both."""

    folder: Path

    @classmethod
    def of(cls, folder: Path, machine: Machine) -> Desk:
        """Make a key, and give it to the target's user; the target may be off."""
        desk = cls(folder)
        make = ["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-C", "desk", "-f", str(folder / "key")]
        subprocess.run(make, check=True)
        host_key = machine.root.joinpath("etc/ssh/ssh_host_ed25519_key.pub").read_text()
        folder.joinpath("known_hosts").write_text(f"{machine.address} {host_key}")
        text = CONFIG.format(host=HOST, address=machine.address, user=USER, folder=folder)
        desk.config.write_text(text)
        _authorise(machine, folder.joinpath("key.pub").read_text())
        return desk

    @property
    def config(self) -> Path:
        return self.folder / "ssh_config"

    def install(self, project: Path) -> None:
        """Install a package of the user's, as who writes a driver does."""
        wheels.install(self._site, [str(project)], "--no-deps")
        wheels.install(self._site, BUILT_WITH)

    def ssh(self, command: str) -> str:
        """Run a command there as the user, by ssh alone; return what it printed."""
        ssh = ["ssh", "-F", str(self.config), HOST, command]
        run = subprocess.run(ssh, capture_output=True, text=True, check=True, timeout=scaled(COMMAND_S))
        return run.stdout

    def rsync(self, folder: Path, there: str) -> None:
        """Send a folder by rsync alone, to one below the user's home."""
        ssh = shlex.join(["ssh", "-F", str(self.config)])
        subprocess.run(["rsync", "--archive", "--compress", "-e", ssh, f"{folder}/", f"{HOST}:{there}/"], check=True)

    def command(self, *arguments: str) -> list[str]:
        """Return the command line of ``robotcore`` with these arguments."""
        return [sys.executable, "-m", "robotcore", *arguments]

    def deploy(self, deed: str, *arguments: str, project: Path | None = None) -> subprocess.CompletedProcess[str]:
        """Type ``robotcore deploy DEED rover …`` in a project's folder, and see what comes of it."""
        return self.typed("deploy", deed, HOST, *arguments, "--ssh-config", str(self.config), project=project)

    def typed(self, *arguments: str, project: Path | None = None) -> subprocess.CompletedProcess[str]:
        """Type a command of robotcore's."""
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

    def deploying(self, deed: str, *arguments: str) -> list[str]:
        """Return the command line that `deploy` types."""
        return self.command("deploy", deed, HOST, *arguments, "--ssh-config", str(self.config))

    @property
    def environment(self) -> dict[str, str]:
        """This checkout's robotcore, and the packages that were installed."""
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
