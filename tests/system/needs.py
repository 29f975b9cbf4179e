"""The needs of the system tests: check the machine, and install missing packages."""

from __future__ import annotations

import fcntl
import os
import platform
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

NOT_RUN = 77
"""The exit status of a test that cannot run here, as in automake."""

ENDING_WITH_US = ("setpriv", "--pdeathsig", "KILL")
"""The beginning of a command that the kernel kills when this process ends."""

ROOT = Path(__file__).parents[2]
RELEASE = "12"
"""The only supported release of Debian."""


class NotRunError(Exception):
    """A test cannot run here; the text says why."""


def run_or_skip(name: str, test: Callable[[], bool]) -> int:
    """Run a test and return its exit status, and print the reason if it cannot run."""
    try:
        return 0 if test() else 1
    except NotRunError as why:
        print(f"{name}: not run: {why}", flush=True)
        return NOT_RUN


def leave_on_sigterm() -> None:
    """Let SIGTERM raise SystemExit, so that contexts are left, as at SIGINT."""
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))


def debian() -> None:
    """Raise NotRunError unless this is the supported Debian on amd64, and this user is root.

    Adds the folders of root's programs to PATH.
    """
    try:
        system = platform.freedesktop_os_release()
    except OSError:
        system = {}
    if (system.get("ID"), system.get("VERSION_ID"), platform.machine()) != ("debian", RELEASE, "x86_64"):
        here = system.get("PRETTY_NAME", platform.system())
        raise NotRunError(f"needs Debian {RELEASE} on x86_64 for its packages; this is {here} on {platform.machine()}")
    if os.geteuid() != 0:
        raise NotRunError("needs root, to install packages and to mount; run it as root, or in a container")
    os.environ["PATH"] = os.pathsep.join([os.environ.get("PATH", os.defpath), "/usr/sbin", "/sbin"])


def packages(*names: str) -> None:
    """Install the missing ones of these Debian packages; raises NotRunError if that fails."""
    missing = [name for name in names if not _is_installed(name)]
    if not missing:
        return
    install = ["install", "--yes", "--no-install-recommends", *missing]
    if _apt(*install) and (fault := _apt("update") or _apt(*install)):
        raise NotRunError(f"needs {', '.join(missing)}, and apt-get failed: {fault}")


def download(folder: Path, *names: str) -> None:
    """Download Debian packages into a folder; raises NotRunError if that fails."""
    if _apt("download", *names, folder=folder) and (fault := _apt("update") or _apt("download", *names, folder=folder)):
        raise NotRunError(f"needs to download {', '.join(names)}, and apt-get failed: {fault}")


def cache() -> Path:
    """Return the cache folder, and make it if it is missing."""
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "robotcore-system"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _is_installed(name: str) -> bool:
    query = ["dpkg-query", "--show", "--showformat", "${db:Status-Status}", name]
    return subprocess.run(query, capture_output=True, text=True, check=False).stdout == "installed"


def _apt(*arguments: str, folder: Path | None = None) -> str:
    """Run apt-get; return the last line of its error, or an empty text on success.

    apt-get does not wait for another apt-get. A lock lets system tests that run at the same time take turns.
    """
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    command = ["apt-get", "--quiet", *arguments]
    with (cache() / "apt.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        run = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, check=False)
    return last_line(run.stderr or run.stdout) if run.returncode else ""


def last_line(text: str) -> str:
    """Return the last line of a program's output."""
    return (text.strip().splitlines() or ["nothing"])[-1]
