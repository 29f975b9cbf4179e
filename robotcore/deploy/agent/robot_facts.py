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

_GROUPS = ("gpio", "i2c", "spi", "video")
"""The groups whose members may use a Raspberry Pi's devices."""

LINGER_FOLDER = Path("/var/lib/systemd/linger")
"""The folder with a file for each user whose services run without a login (lingering). Source: systemd's loginctl."""

_MODEL = Path("/proc/device-tree/model")

MANAGER_TIMEOUT_S = 5.0
"""How long the user's systemd may take to start after lingering was turned on, in s."""


def read_user() -> str:
    """Return the name of the user who is logged in, from the system's user database."""
    return pwd.getpwuid(os.getuid()).pw_name


def build_environment() -> dict[str, str]:
    """Return the environment of systemd's tools: the user's runtime folder, and output in English without colours."""
    return {**os.environ, "XDG_RUNTIME_DIR": str(find_runtime_folder()), "LC_ALL": "C.UTF-8", "SYSTEMD_COLORS": "0"}


def collect_facts(layout: Layout) -> dict[str, Any]:
    """Return the facts about this robot that the client needs to decide whether a release can run on it.

    The function needs no root. If a program or a file is missing, it raises nothing.
    """
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
    """Return the model of the board, such as ``Raspberry Pi 4 Model B``; empty if the system does not state it."""
    with suppress(OSError):
        return _MODEL.read_text(errors="replace").rstrip("\0")
    return ""


def count_bits() -> int:
    """Return the word size of the installed programs in bits, 32 or 64. The kernel may have another one."""
    return 64 if sys.maxsize > 2**32 else 32


def has_venv() -> bool:
    """Return whether Python can make virtual environments with pip. On Debian this needs the package python3-venv."""
    return bool(find_spec("venv") and find_spec("ensurepip"))


def is_lingering() -> bool:
    """Return whether the services of this user run without a login."""
    return (LINGER_FOLDER / read_user()).exists()


def has_user_manager() -> bool:
    """Return whether the systemd instance of this user runs."""
    return _succeeds("systemctl", "--user", "show", "--property=Version")


def can_read_journal() -> bool:
    """Return whether this user may read the output of their services in systemd's journal."""
    return _succeeds("journalctl", "--user", "--lines=0", "--quiet")


def read_groups() -> dict[str, bool]:
    """Return whether the user is a member, by the name of each device group that exists on this robot."""
    mine = {*os.getgroups(), os.getgid()}
    return {group.gr_name: group.gr_gid in mine for group in grp.getgrall() if group.gr_name in _GROUPS}


def _succeeds(*command: str) -> bool:
    try:
        done = subprocess.run(  # noqa: S603
            command, env=build_environment(), capture_output=True, timeout=10, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0


def require_push_needs(facts: dict[str, object], *, has_environment: bool) -> None:
    """Raise AgentError if the robot lacks something that a push needs. The error lists everything that is missing.

    The function turns lingering on if the user may do that.

    facts: as `collect_facts` returns them.
    has_environment: whether the environment of the release exists already. If it does, python3-venv is not needed.
    """
    if missing := list(_list_missing(facts, has_environment=has_environment)):
        faults, remedies, kinds = zip(*missing, strict=True)
        raise AgentError(". ".join(faults), ". ".join(remedies), kinds[0], kinds=kinds)


def _list_missing(facts: dict[str, object], *, has_environment: bool) -> Iterator[tuple[str, str, str]]:
    """Yield what is missing, its remedy, and the kind of the error, for each need that the robot lacks."""
    if facts["bits"] != 64:
        yield (
            f"{facts['system']} is a 32-bit system, for which NumPy and OpenCV have no wheels",
            "Put the 64-bit Raspberry Pi OS on it",
            "architecture",
        )
    if not facts["has_rsync"]:
        yield "rsync is missing on the robot", "On the robot: sudo apt install rsync", "rsync"
    if not facts["has_venv"] and not has_environment:
        yield "python3-venv is missing on the robot", "On the robot: sudo apt install python3-venv", "venv"
    if not enable_lingering():
        yield _describe_no_linger()
    elif not wait_for_user_manager():
        yield (
            "systemd runs no services of this user on the robot",
            "For the reason, on the robot: systemctl --user status",
            "manager",
        )


def require_lingering() -> None:
    """Raise AgentError if the user's systemd would end as soon as the ssh connection is closed."""
    if not enable_lingering():
        raise AgentError(*_describe_no_linger())


def _describe_no_linger() -> tuple[str, str, str]:
    user = read_user()
    fault = f"lingering is off, so the services of {user} run only during a login"
    return fault, f"On the robot: sudo loginctl enable-linger {user}", "linger"


def enable_lingering() -> bool:
    """Turn lingering on if it is off and the user may do that. Return whether lingering is on then."""
    if not is_lingering():
        with suppress(OSError, subprocess.TimeoutExpired):
            command = ["loginctl", "--no-ask-password", "enable-linger"]
            subprocess.run(command, capture_output=True, timeout=10, check=False)  # noqa: S603
    return is_lingering()


def wait_for_user_manager() -> bool:
    """Wait at most `MANAGER_TIMEOUT_S` until the systemd instance of this user runs; return whether it runs."""
    for _ in range(round(MANAGER_TIMEOUT_S)):
        if has_user_manager():
            return True
        Event().wait(1)
    return False
