"""Wheels: install packages into a folder for this processor or arm64, and build this checkout's wheel."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from tests.system import needs

ARM64_PIP = ("manylinux_2_17_aarch64", "manylinux2014_aarch64", "manylinux_2_28_aarch64")
ARM64_UV = "aarch64-manylinux_2_28"


def install(folder: Path, packages: Iterable[str], *options: str) -> None:
    """Install packages into a folder; raises NotRunError if that fails."""
    uv = shutil.which("uv")
    command = [uv, "pip", "install", "--python", sys.executable] if uv else [sys.executable, "-m", "pip", "install"]
    run = subprocess.run(
        [*command, "--quiet", "--target", folder, *options, *packages], capture_output=True, text=True, check=False
    )
    if run.returncode:
        raise needs.NotRunError(f"needs {' '.join(packages)}: {needs.last_line(run.stderr)}")


def install_for_arm64(folder: Path, packages: Iterable[str], python: str) -> None:
    """Install packages for arm64 and a version of Python; raises NotRunError if that fails."""
    if shutil.which("uv"):
        platforms = ["--python-platform", ARM64_UV]
    else:
        platforms = [option for name in ARM64_PIP for option in ("--platform", name)]
    install(folder, packages, *platforms, "--python-version", python, "--only-binary=:all:")


def build(folder: Path) -> Path:
    """Build this checkout's wheel into a folder, and return its path."""
    installer = ["--installer", "uv"] if shutil.which("uv") else []
    command = [sys.executable, "-m", "build", "--wheel", *installer, "--outdir", str(folder), str(needs.ROOT)]
    subprocess.run(command, capture_output=True, check=True)
    (wheel,) = folder.glob("*.whl")
    return wheel
