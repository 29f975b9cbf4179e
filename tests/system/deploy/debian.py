"""Debian as Raspberry Pi OS 12 has it, in a folder: systemd, sshd, rsync and Python; made once and kept."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.system import needs

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


def copy_to(root: Path) -> None:
    """Copy it into a new folder, so that each run begins with a robot that nobody has touched."""
    subprocess.run(["cp", "--archive", "--reflink=auto", made(), root], check=True)


def made() -> Path:
    """Return where it is kept, made where it is not; raises NotRunError where that fails."""
    root = needs.cache() / f"deploy-{SUITE}"
    if not root.is_dir():
        with TemporaryDirectory(dir=needs.cache()) as scratch:
            _make(Path(scratch) / "root").replace(root)
    return root


def _make(root: Path) -> Path:
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
