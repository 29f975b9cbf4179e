"""A Debian for arm64 in a folder, with Python, whose programs are emulated."""

from __future__ import annotations

import platform
import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.system import needs, wheels

TOOLS = ("debootstrap", "qemu-user-static")
EMULATOR = Path("/usr/bin/qemu-aarch64-static")
PYTHON = "3.11"
NO_OPENGL = "MUJOCO_GL=disable"
"""Otherwise MuJoCo looks for GLFW by starting another Python, which is not emulated."""

MERGED = ("bin", "lib", "sbin")
"""Debian's folders that are links into /usr."""


@dataclass(frozen=True)
class Target:
    """A root folder for arm64. Each command has mounts of its own, which end with it."""

    root: Path

    def command(self, site: str, *arguments: str) -> list[str]:
        """Return the command that runs Python in the folder, with the packages of a folder in ``sites``."""
        isolated = [
            *needs.ENDING_WITH_US,
            "unshare",
            "--mount",
            "--pid",
            "--fork",
            "--kill-child",
            "--mount-proc=/proc",
            f"--root={self.root}",
        ]
        settings = ["-E", f"PYTHONPATH=/sites/{site}", "-E", NO_OPENGL]
        python = [f"/{EMULATOR.name}", *settings, f"/usr/bin/python{PYTHON}"]
        return [*isolated, *python, *arguments]

    def install(self, site: str, packages: Iterable[str]) -> None:
        """Install packages for arm64 into a folder in ``sites``; raises NotRunError if that fails."""
        folder = self.root / "sites" / site
        shutil.rmtree(folder, ignore_errors=True)
        wheels.install_for_arm64(folder, packages, PYTHON)


def target() -> Target:
    """Return the target, and make it if it is not in the cache; raises NotRunError if that fails."""
    if platform.machine() != "x86_64":
        raise needs.NotRunError(f"needs x86_64, to emulate arm64 on; this is {platform.machine()}")
    needs.packages(*TOOLS)
    root = needs.cache() / "arm64-bookworm"
    if not root.is_dir():
        with TemporaryDirectory(dir=needs.cache()) as scratch:
            _make(Path(scratch) / "root").replace(root)
    return Target(root)


def _make(root: Path) -> Path:
    """Unpack Debian's packages without configuring them: emulated, that would take a quarter of an hour."""
    command = ["debootstrap", "--download-only", "--arch=arm64", "--variant=minbase", "--include=python3", "bookworm"]
    run = subprocess.run([*command, root], capture_output=True, text=True, check=False)
    if run.returncode:
        raise needs.NotRunError(f"needs Debian's packages for arm64: {needs.last_line(run.stdout)}")
    for name in MERGED:
        root.joinpath("usr", name).mkdir(parents=True)
        root.joinpath(name).symlink_to(f"usr/{name}")
    archives = root / "var" / "cache" / "apt" / "archives"
    for package in sorted(archives.glob("*.deb")):
        _unpack(package, root)
    shutil.rmtree(archives)
    shutil.copy(EMULATOR, root)
    return root


def _unpack(package: Path, root: Path) -> None:
    with subprocess.Popen(["dpkg-deb", "--fsys-tarfile", package], stdout=subprocess.PIPE) as tar:
        command = ["tar", "--extract", "--keep-directory-symlink", "--directory", str(root)]
        subprocess.run(command, stdin=tar.stdout, check=True)
