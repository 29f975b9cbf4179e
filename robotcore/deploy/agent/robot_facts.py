"""Facts about the robot: its user, system and packages, and the checks of what a push needs."""

from __future__ import annotations

import grp
import os
import platform
import pwd
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from datetime import datetime, timezone
from importlib.util import find_spec
from pathlib import Path
from threading import Event
from typing import Any

from robotcore.deploy.agent.files import Layout, find_runtime_folder, measure_free_space
from robotcore.deploy.agent.rpc import AgentError


def read_user() -> str:
    """Return who is logged in, by the system's word: the environment may have another one."""
    return pwd.getpwuid(os.getuid()).pw_name


def build_environment() -> dict[str, str]:
    """Return what a program needs to find the user's systemd and journal, and to speak so that it is understood."""
    return {**os.environ, "XDG_RUNTIME_DIR": str(find_runtime_folder()), "LC_ALL": "C.UTF-8", "SYSTEMD_COLORS": "0"}


_GROUPS = ("gpio", "i2c", "spi", "video")
"""Who may use a Raspberry Pi's devices."""

LINGER_FOLDER = Path("/var/lib/systemd/linger")
"""Has a file for each user whose services run without them being logged in. Source: systemd's loginctl."""

_MODEL = Path("/proc/device-tree/model")


def collect_facts(layout: Layout) -> dict[str, Any]:
    """Return what the desk is told; all of it is found without root, and nothing fails where something is missing."""
    libc, libc_version = platform.libc_ver()
    return {
        "host": platform.node(),
        "user": read_user(),
        "home": str(layout.home),
        "system": read_system(),
        "model": read_model(),
        "machine": platform.machine(),
        "bits": count_bits(),
        "python": platform.python_version(),
        "libc": libc,
        "libc_version": libc_version,
        "free_bytes": measure_free_space(layout.root),
        "has_rsync": bool(shutil.which("rsync")),
        "has_venv": has_venv(),
        "has_user_manager": has_user_manager(),
        "is_lingering": is_lingering(),
        "groups": read_groups(),
        "reads_journal": can_read_journal(),
        "time": datetime.now(timezone.utc).isoformat(timespec="seconds"),
    }


def read_system() -> str:
    """Return the operating system's name."""
    with suppress(OSError):
        return platform.freedesktop_os_release()["PRETTY_NAME"]
    return platform.system()


def read_model() -> str:
    """Return which board it is; empty where none tells."""
    with suppress(OSError):
        return _MODEL.read_text(errors="replace").rstrip("\0")
    return ""


def count_bits() -> int:
    """Return the bits of programs here, whatever the kernel has."""
    return 64 if sys.maxsize > 2**32 else 32


def has_venv() -> bool:
    """Return whether Python can make environments with pip in them; Debian has that apart."""
    return bool(find_spec("venv") and find_spec("ensurepip"))


def is_lingering() -> bool:
    """Return whether this user's services run without them being logged in."""
    return (LINGER_FOLDER / read_user()).exists()


def has_user_manager() -> bool:
    """Return whether systemd serves this user."""
    return _succeeds("systemctl", "--user", "show", "--property=Version")


def can_read_journal() -> bool:
    """Return whether this user may read what their services say."""
    return _succeeds("journalctl", "--user", "--lines=0", "--quiet")


def read_groups() -> dict[str, bool]:
    """Return of those groups that there are here whether the user is in them."""
    mine = {*os.getgroups(), os.getgid()}
    return {group.gr_name: group.gr_gid in mine for group in grp.getgrall() if group.gr_name in _GROUPS}


def _succeeds(*command: str) -> bool:
    try:
        asked = subprocess.run(  # noqa: S603
            command, env=build_environment(), capture_output=True, timeout=10, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return asked.returncode == 0


MANAGER_TIMEOUT_S = 5.0
"""In which a user's systemd comes up once lingering is on."""


def require_push_needs(told: dict[str, object], *, has_environment: bool) -> None:
    """Look whether a release can be put here, by the facts; raises RefusalError with all that is missing.

    Lingering is turned on where that is allowed.
    """
    if missing := list(_list_missing(told, has_environment=has_environment)):
        faults, remedies, kinds = zip(*missing, strict=True)
        raise AgentError(". ".join(faults), ". ".join(remedies), kinds[0], kinds=kinds)


def _list_missing(told: dict[str, object], *, has_environment: bool) -> Iterator[tuple[str, str, str]]:
    """Yield each fault with its remedy and its kind."""
    if told["bits"] != 64:
        yield (
            f"{told['system']} is a 32-bit system, for which NumPy and OpenCV have no wheels",
            "Put the 64-bit Raspberry Pi OS on it",
            "architecture",
        )
    if not told["has_rsync"]:
        yield "there is no rsync on the robot", "There: sudo apt install rsync", "rsync"
    if not told["has_venv"] and not has_environment:
        yield "python3-venv is missing on the robot", "There: sudo apt install python3-venv", "venv"
    if not enable_lingering():
        yield _describe_no_linger()
    elif not wait_for_user_manager():
        yield "systemd serves no user sessions on the robot", "There: systemctl --user status says why", "manager"


def require_lingering() -> None:
    """Raise RefusalError where the user's systemd would end with the connection."""
    if not enable_lingering():
        raise AgentError(*_describe_no_linger())


def _describe_no_linger() -> tuple[str, str, str]:
    user = read_user()
    fault = f"lingering is off: nothing of {user}'s runs while they are not logged in"
    return fault, f"There: sudo loginctl enable-linger {user}", "linger"


def enable_lingering() -> bool:
    """Return whether lingering is on; it is turned on where this user may do so."""
    if not is_lingering():
        with suppress(OSError, subprocess.TimeoutExpired):
            command = ["loginctl", "--no-ask-password", "enable-linger"]
            subprocess.run(command, capture_output=True, timeout=10, check=False)  # noqa: S603
    return is_lingering()


def wait_for_user_manager() -> bool:
    """Return whether systemd serves this user, at once or within a few seconds."""
    for _ in range(round(MANAGER_TIMEOUT_S)):
        if has_user_manager():
            return True
        Event().wait(1)
    return False
