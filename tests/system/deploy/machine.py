"""Debian as Raspberry Pi OS 12 has it, in a folder: systemd, sshd, rsync and Python; made once and kept."""

from __future__ import annotations

import os
import shutil
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
from tests.system.deploy.isolation import Network, network, own_group
from tests.system.speed import scaled

SUITE = "bookworm"
INCLUDED = (
    "dbus",
    "dbus-user-session",
    "libpam-systemd",
    "openssh-server",
    "python3",
    "python3-venv",
    "rsync",
    "systemd",
    "systemd-sysv",
)
USER = "pi"
LISTENING = "ssh.service"
SOCKET = "ssh.socket"
"""Listens in sshd's place where it is enabled, on a port of its own."""


def copy_debian(root: Path) -> None:
    """Copy it into a new folder, so that each run begins with a robot that nobody has touched."""
    subprocess.run(["cp", "--archive", "--reflink=auto", build_debian(), root], check=True)


def build_debian() -> Path:
    """Return where it is kept, made where it is not; raises NotRunError where that fails."""
    root = needs.cache() / f"deploy-{SUITE}"
    if not root.is_dir():
        with TemporaryDirectory(dir=needs.cache()) as scratch:
            _bootstrap(Path(scratch) / "root").replace(root)
    return root


def _bootstrap(root: Path) -> Path:
    command = ["debootstrap", "--variant=minbase", f"--include={','.join(INCLUDED)}", SUITE, str(root)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode:
        raise needs.NotRunError(f"needs Debian's packages: {needs.last_line(run.stdout)}")
    in_root = ["chroot", str(root)]
    for change in (
        ["useradd", "--create-home", "--shell", "/bin/bash", USER],
        ["systemctl", "disable", SOCKET],
        ["systemctl", "enable", LISTENING],
    ):
        subprocess.run([*in_root, *change], capture_output=True, check=True)
    root.joinpath("etc", "hostname").write_text("rover\n")
    _linger(root)
    shutil.rmtree(root / "var" / "cache" / "apt" / "archives")
    return root


def _linger(root: Path) -> None:
    """Let the user's services run without a login: what ``loginctl enable-linger`` leaves behind."""
    folder = root / "var" / "lib" / "systemd" / "linger"
    folder.mkdir(parents=True, exist_ok=True)
    folder.joinpath(USER).touch()


TOOLS = ("debootstrap", "systemd-container", "iproute2", "openssh-client", "rsync")
BOOT_S = 60.0
"""On the reference machine: a hang; it is up in 2 s."""

SSH_PORT = 22
NAMESPACES = ("--mount", "--uts", "--ipc", "--net", "--pid", "--cgroup")
ALONE = ("unshare", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc")
"""Runs a command in a namespace of processes: systemd-nspawn, killed, leaves what it has booted to itself."""

CONSOLE = needs.ROOT / "build" / f"deploy-console-{os.environ.get('PYTEST_XDIST_WORKER', 'gw')}.log"


@dataclass
class Machine:
    """A Debian on ``root``, booted by systemd-nspawn; what it says on its console is kept in ``build``."""

    root: Path
    network: Network
    group: Sequence[str]
    _booted: subprocess.Popen[bytes] | None = field(default=None, init=False)

    @property
    def address(self) -> str:
        return self.network.address

    @property
    def home(self) -> Path:
        """The user's home, as this machine finds it: with what is mounted there while the target is up."""
        is_up = self._booted is not None and self._booted.poll() is None
        root = Path(f"/proc/{self._init}/root") if is_up else self.root
        return root / "home" / USER

    def boot(self) -> None:
        """Switch it on, and return when its sshd answers."""
        command = self.command("--boot")
        with CONSOLE.open("ab") as console:
            self._booted = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=console, stderr=console)
        self._await_sshd(self._booted)

    def command(self, *arguments: str) -> list[str]:
        """Return the command that runs systemd-nspawn on it, in a network, a group and a namespace of its own."""
        nspawn = ["systemd-nspawn", "--quiet", "--register=no", "--keep-unit", f"--directory={self.root}", *arguments]
        return [*needs.ENDING_WITH_US, *self.group, *self.network.entering, *ALONE, *nspawn]

    def cut_power(self) -> None:
        """End all that runs on it at once, in the middle of whatever it does."""
        if self._booted and self._booted.poll() is None:
            os.kill(_child(self._booted.pid), signal.SIGKILL)
            self._booted.wait(scaled(BOOT_S))  # the first of a namespace is not gone before all the others are

    def shut_down(self) -> None:
        """Let it go down in good order."""
        self.as_root("systemctl", "poweroff")
        self._running.wait(scaled(BOOT_S))

    def as_root(self, *command: str, is_checked: bool = True) -> str:
        """Run a command on it as root; return what it printed."""
        entering = ["nsenter", f"--target={self._init}", *NAMESPACES, "--"]
        run = subprocess.run([*entering, *command], stdout=subprocess.PIPE, text=True, check=is_checked)
        return run.stdout

    @property
    def _init(self) -> int:
        return _child(_child(self._running.pid))

    @property
    def _running(self) -> subprocess.Popen[bytes]:
        assert self._booted, "boot it first"
        return self._booted

    def _await_sshd(self, booted: subprocess.Popen[bytes]) -> None:
        ending = time.monotonic() + scaled(BOOT_S)
        while not self._answers():
            if booted.poll() is not None or time.monotonic() > ending:
                self.cut_power()
                said = needs.last_line(CONSOLE.read_text(errors="replace"))
                raise RuntimeError(f"the target has not come up; its console says: {said}")
            time.sleep(0.05)

    def _answers(self) -> bool:
        try:
            with socket.create_connection((self.address, SSH_PORT), timeout=scaled(1.0)) as connection:
                return connection.recv(4) == b"SSH-"
        except OSError:
            return False


def _child(process: int) -> int:
    (child,) = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    return int(child)


def require_machine() -> None:
    """Raise NotRunError where no target could be booted: a command is run on it, as it is kept."""
    needs.debian()
    needs.packages(*TOOLS)
    with own_group() as group, network() as wire:
        command = Machine(build_debian(), wire, group).command("--read-only", "true")
        run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode:
        raise needs.NotRunError(f"needs what systemd-nspawn does, and it said: {needs.last_line(run.stderr)}")


@contextmanager
def make_machine() -> Iterator[Machine]:
    """Copy a Debian and make it ready to boot, where `require_machine` has none against it; it ends with this block."""
    CONSOLE.parent.mkdir(exist_ok=True)
    CONSOLE.unlink(missing_ok=True)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory(prefix="robotcore-target-")))
        group = stack.enter_context(own_group())
        made = Machine(folder / "root", stack.enter_context(network()), group)
        copy_debian(made.root)
        stack.callback(made.cut_power)
        yield made
