"""The robot: a Debian 12 as a folder, like Raspberry Pi OS 12, that systemd-nspawn boots. Its power can be cut."""

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
from tests.system.deploy.isolation import Network, make_group, make_network
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
SSH_SERVICE = "ssh.service"
SSH_SOCKET = "ssh.socket"
"""If it is enabled, systemd listens on another port in place of sshd."""


def copy_debian(root: Path) -> None:
    """Copy the Debian into a new folder, so that each run begins with a fresh robot."""
    subprocess.run(["cp", "--archive", "--reflink=auto", build_debian(), root], check=True)


def build_debian() -> Path:
    """Return the folder of the Debian. The first call makes it; raises NotRunError if that fails."""
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
        ["systemctl", "disable", SSH_SOCKET],
        ["systemctl", "enable", SSH_SERVICE],
    ):
        subprocess.run([*in_root, *change], capture_output=True, check=True)
    root.joinpath("etc", "hostname").write_text("rover\n")
    _linger(root)
    shutil.rmtree(root / "var" / "cache" / "apt" / "archives")
    return root


def _linger(root: Path) -> None:
    """Let the user's services run without a login, as ``loginctl enable-linger`` does."""
    folder = root / "var" / "lib" / "systemd" / "linger"
    folder.mkdir(parents=True, exist_ok=True)
    folder.joinpath(USER).touch()


TOOLS = ("debootstrap", "systemd-container", "iproute2", "openssh-client", "rsync")
BOOT_S = 60.0
"""The time limit of a boot on the reference machine, in s. A boot takes 2 s."""

SSH_PORT = 22
NAMESPACES = ("--mount", "--uts", "--ipc", "--net", "--pid", "--cgroup")
OWN_PROCESSES = ("unshare", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc")
"""Runs a command in a namespace of processes, because a killed systemd-nspawn does not end the robot."""

CONSOLE = needs.ROOT / "build" / f"deploy-console-{os.environ.get('PYTEST_XDIST_WORKER', 'gw')}.log"


@dataclass
class Machine:
    """A Debian that systemd-nspawn boots. The log of its console is in ``build``."""

    root: Path
    network: Network
    group: Sequence[str]
    _booted: subprocess.Popen[bytes] | None = field(default=None, init=False)

    @property
    def address(self) -> str:
        return self.network.address

    @property
    def home(self) -> Path:
        """The user's home as a path on this machine. While the robot runs, it has the robot's mounts."""
        is_up = self._booted is not None and self._booted.poll() is None
        root = Path(f"/proc/{self._init}/root") if is_up else self.root
        return root / "home" / USER

    def boot(self) -> None:
        """Switch the robot on, and wait until its sshd answers."""
        command = self.command("--boot")
        with CONSOLE.open("ab") as console:
            self._booted = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=console, stderr=console)
        self._await_sshd(self._booted)

    def command(self, *arguments: str) -> list[str]:
        """Return the command of systemd-nspawn, with the robot's own network, control group and namespaces."""
        nspawn = ["systemd-nspawn", "--quiet", "--register=no", "--keep-unit", f"--directory={self.root}", *arguments]
        return [*needs.ENDING_WITH_US, *self.group, *self.network.command_prefix, *OWN_PROCESSES, *nspawn]

    def cut_power(self) -> None:
        """Kill all processes of the robot at once."""
        if self._booted and self._booted.poll() is None:
            os.kill(_child(self._booted.pid), signal.SIGKILL)
            self._booted.wait(scaled(BOOT_S))  # the first process of a namespace ends last

    def shut_down(self) -> None:
        """Shut the robot down in an orderly way."""
        self.as_root("systemctl", "poweroff")
        self._running.wait(scaled(BOOT_S))

    def as_root(self, *command: str, is_checked: bool = True) -> str:
        """Run a command on the robot as root; return its output."""
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
        while not self._is_sshd_up():
            if booted.poll() is not None or time.monotonic() > ending:
                self.cut_power()
                last = needs.last_line(CONSOLE.read_text(errors="replace"))
                raise RuntimeError(f"the robot did not boot; the last line of its console: {last}")
            time.sleep(0.05)

    def _is_sshd_up(self) -> bool:
        try:
            with socket.create_connection((self.address, SSH_PORT), timeout=scaled(1.0)) as connection:
                return connection.recv(4) == b"SSH-"
        except OSError:
            return False


def _child(process: int) -> int:
    (child,) = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    return int(child)


def require_machine() -> None:
    """Raise NotRunError if no robot can be booted here; it runs a command on one to find out."""
    needs.debian()
    needs.packages(*TOOLS)
    with make_group() as group, make_network() as link:
        command = Machine(build_debian(), link, group).command("--read-only", "true")
        run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode:
        raise needs.NotRunError(f"needs systemd-nspawn, which failed: {needs.last_line(run.stderr)}")


@contextmanager
def make_machine() -> Iterator[Machine]:
    """Make a robot that can be booted, and delete it at the end. Call `require_machine` first."""
    CONSOLE.parent.mkdir(exist_ok=True)
    CONSOLE.unlink(missing_ok=True)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory(prefix="robotcore-target-")))
        group = stack.enter_context(make_group())
        machine = Machine(folder / "root", stack.enter_context(make_network()), group)
        copy_debian(machine.root)
        stack.callback(machine.cut_power)
        yield machine
