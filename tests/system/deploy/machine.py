"""The target: a computer of its own to all who look, with power that can be cut."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.system import needs
from tests.system.deploy import debian
from tests.system.deploy.cgroup import own_group
from tests.system.deploy.network import Network, network

TOOLS = ("debootstrap", "systemd-container", "iproute2", "openssh-client", "rsync")
BOOT_S = 60.0
"""A hang; on a machine of its own it is up in 2 s."""

SSH_PORT = 22


@dataclass
class Machine:
    """A Debian on ``root``, booted by systemd-nspawn; what its console says is kept in a file."""

    root: Path
    console: Path
    network: Network
    group: Sequence[str]
    _nspawn: subprocess.Popen[bytes] | None = field(default=None, init=False)

    @property
    def address(self) -> str:
        return self.network.address

    @property
    def home(self) -> Path:
        """The user's home, as this machine finds it while the target is up or down."""
        return self.root / "home" / debian.USER

    def boot(self) -> None:
        """Switch it on, and return when its sshd answers; raises NotRunError where it does not come up."""
        command = [*needs.ENDING_WITH_US, *self.group, "systemd-nspawn", "--quiet", "--directory", str(self.root)]
        booting = ["--boot", "--register=no", "--keep-unit", f"--network-namespace-path={self.network.path}"]
        with self.console.open("ab") as console:
            self._nspawn = subprocess.Popen(
                [*command, *booting], stdin=subprocess.DEVNULL, stdout=console, stderr=subprocess.STDOUT
            )
        self._await_sshd(self._nspawn)

    def cut_power(self) -> None:
        """End all that runs on it at once, in the middle of whatever it does."""
        if self._nspawn and self._nspawn.poll() is None:
            os.kill(self._init(), signal.SIGKILL)  # nobody below it outlives it; systemd-nspawn goes by itself
            self._nspawn.wait(BOOT_S)

    def reboot(self) -> None:
        """Let it go down in good order, as its user may ask for, and switch it on again."""
        assert self._nspawn
        self.as_root("systemctl", "reboot")
        self._nspawn.wait(BOOT_S)
        self.boot()

    def restart(self) -> None:
        """Cut its power, and switch it on again."""
        self.cut_power()
        self.boot()

    def as_root(self, *command: str, is_checked: bool = True) -> str:
        """Run a command on it as root; return what it printed."""
        entering = [
            "nsenter",
            f"--target={self._init()}",
            "--mount",
            "--uts",
            "--ipc",
            "--net",
            "--pid",
            "--cgroup",
            "--",
        ]
        run = subprocess.run([*entering, *command], stdout=subprocess.PIPE, text=True, check=is_checked)
        return run.stdout

    def _init(self) -> int:
        assert self._nspawn
        (init,) = Path(f"/proc/{self._nspawn.pid}/task/{self._nspawn.pid}/children").read_text().split()
        return int(init)

    def _await_sshd(self, nspawn: subprocess.Popen[bytes]) -> None:
        ending = time.monotonic() + BOOT_S
        while not self._answers():
            if nspawn.poll() is not None or time.monotonic() > ending:
                self.cut_power()
                said = needs.last_line(self.console.read_text(errors="replace"))
                raise needs.NotRunError(f"needs to boot a Debian, and systemd-nspawn said: {said}")
            time.sleep(0.05)

    def _answers(self) -> bool:
        try:
            with socket.create_connection((self.address, SSH_PORT), timeout=1.0) as connection:
                return connection.recv(4) == b"SSH-"
        except OSError:
            return False


@contextmanager
def machine(console: Path) -> Iterator[Machine]:
    """Copy a Debian and make it ready to boot; it ends with this block, for sure. Raises NotRunError."""
    needs.debian()
    needs.packages(*TOOLS)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory(prefix="robotcore-target-")))
        group = stack.enter_context(own_group())
        made = Machine(folder / "root", console, stack.enter_context(network()), group)
        debian.copy_to(made.root)
        stack.callback(made.cut_power)
        yield made
