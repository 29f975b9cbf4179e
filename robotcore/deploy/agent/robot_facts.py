"""Facts about the robot, such as its user, system and packages, and checks of the requirements of a push."""

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
"""The user groups with access to a Raspberry Pi's devices."""

LINGER_FOLDER = Path("/var/lib/systemd/linger")
"""The folder with a file for each user with lingering: services that run without a login. Source: loginctl(1)."""

_MODEL = Path("/proc/device-tree/model")

MANAGER_TIMEOUT_S = 5.0
"""The time limit for the start of the user's systemd after lingering was turned on, in s."""


def read_user() -> str:
    """Return the name of the user of this process."""
    return pwd.getpwuid(os.getuid()).pw_name


def build_environment() -> dict[str, str]:
    """Return the environment variables for systemd's tools: the runtime folder, and plain output in English."""
    return {**os.environ, "XDG_RUNTIME_DIR": str(find_runtime_folder()), "LC_ALL": "C.UTF-8", "SYSTEMD_COLORS": "0"}


def collect_facts(layout: Layout) -> dict[str, Any]:
    """Return the facts about this robot that decide whether a release can run on it.

    The function needs no root. It raises nothing if a program or a file is missing.
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
    """Return the model of the board, such as ``Raspberry Pi 4 Model B``; empty for an unknown board."""
    with suppress(OSError):
        return _MODEL.read_text(errors="replace").rstrip("\0")
    return ""


def count_bits() -> int:
    """Return the word size of the installed programs in bits, 32 or 64. That of the kernel may differ."""
    return 64 if sys.maxsize > 2**32 else 32


def has_venv() -> bool:
    """Return whether Python can create virtual environments with pip. On Debian this needs the package python3-venv."""
    return bool(find_spec("venv") and find_spec("ensurepip"))


def is_lingering() -> bool:
    """Return whether lingering is on for this user, so that the user's services run without a login."""
    return (LINGER_FOLDER / read_user()).exists()


def has_user_manager() -> bool:
    """Return whether this user's systemd runs."""
    return _succeeds("systemctl", "--user", "show", "--property=Version")


def can_read_journal() -> bool:
    """Return whether this user may read the output of the user's services in systemd's journal."""
    return _succeeds("journalctl", "--user", "--lines=0", "--quiet")


def read_groups() -> dict[str, bool]:
    """Return for each device group on this robot, by its name, whether the user is a member."""
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
    """Raise AgentError with a list of all requirements of a push that the robot does not meet.

    The function turns lingering on if the user may do that.

    facts: the result of `collect_facts`.
    has_environment: whether the environment of the release exists already, so that python3-venv is not needed.
    """
    if missing := list(_list_missing(facts, has_environment=has_environment)):
        problems, remedies, kinds = zip(*missing, strict=True)
        raise AgentError(". ".join(problems), ". ".join(remedies), kinds[0], kinds=kinds)


def _list_missing(facts: dict[str, object], *, has_environment: bool) -> Iterator[tuple[str, str, str]]:
    """Yield the problem, the remedy and the kind of the error for each requirement that the robot does not meet."""
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
    """Turn lingering on. Raise AgentError if it stays off, because services then end with the ssh connection."""
    if not enable_lingering():
        raise AgentError(*_describe_no_linger())


def _describe_no_linger() -> tuple[str, str, str]:
    user = read_user()
    problem = f"lingering is off, so the services of {user} run only during a login"
    return problem, f"On the robot: sudo loginctl enable-linger {user}", "linger"


def enable_lingering() -> bool:
    """Turn lingering on if the user may do that. Return whether lingering is on."""
    if not is_lingering():
        with suppress(OSError, subprocess.TimeoutExpired):
            command = ["loginctl", "--no-ask-password", "enable-linger"]
            subprocess.run(command, capture_output=True, timeout=10, check=False)  # noqa: S603
    return is_lingering()


def wait_for_user_manager() -> bool:
    """Wait at most `MANAGER_TIMEOUT_S` until this user's systemd runs. Return whether it runs."""
    for _ in range(round(MANAGER_TIMEOUT_S)):
        if has_user_manager():
            return True
        Event().wait(1)
    return False
