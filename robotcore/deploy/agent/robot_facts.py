"""Facts about the robot, such as its user and its system, and checks of the requirements of a push."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout, find_runtime_folder, measure_free_space

LINGER_FOLDER = Path("/var/lib/systemd/linger")
"""The folder with a file for each user with lingering: services that run without a login. Source: loginctl(1)."""

MANAGER_TIMEOUT_S = 5
"""The time limit for the start of the user's systemd after lingering was turned on, in s."""


class Need(NamedTuple):
    """A requirement that the robot does not meet: the arguments of an AgentError."""

    problem: str
    remedy: str
    kind: str


NO_SYSTEMD = Need(
    "systemd is missing on the robot",
    "Install a system with it, such as Raspberry Pi OS, Debian or Ubuntu",
    "no-systemd",
)


def read_user() -> str:
    """Return the name of the user of this process."""
    import pwd  # the computer of the developer, which imports this module too, may lack it

    return pwd.getpwuid(os.getuid()).pw_name


def build_environment() -> dict[str, str]:
    """Return the environment variables for systemd's tools: the runtime folder, and plain output in English."""
    return {**os.environ, "XDG_RUNTIME_DIR": str(find_runtime_folder()), "LC_ALL": "C.UTF-8", "SYSTEMD_COLORS": "0"}


def collect_facts(layout: Layout) -> dict[str, Any]:
    """Return the facts about this robot that a push reports, see `robot_answers.ProbeAnswer`."""
    libc, libc_version = platform.libc_ver()
    return {
        "host": platform.node(),
        "machine": platform.machine(),
        "system": read_system(),
        "python": platform.python_version(),
        "libc": libc,
        "libc_version": libc_version,
        "free_bytes": measure_free_space(layout.root),
    }


def read_system() -> str:
    """Return the operating system's name."""
    with suppress(OSError):
        return platform.freedesktop_os_release()["PRETTY_NAME"]
    return platform.system()


def count_bits() -> int:
    """Return the word size of the installed programs in bits, 32 or 64. That of the kernel may differ."""
    return 64 if sys.maxsize > 2**32 else 32


def has_venv() -> bool:
    """Return whether Python can create virtual environments with pip. On Debian this needs the package python3-venv."""
    return bool(find_spec("venv") and find_spec("ensurepip"))


def is_lingering() -> bool:
    """Return whether lingering is on for this user, so that the user's services run without a login."""
    return (LINGER_FOLDER / read_user()).exists()


def require_push_needs(*, has_environment: bool) -> None:
    """Raise AgentError with a list of all requirements of a push that the robot does not meet.

    The function turns lingering on if the user may do that.

    has_environment: whether the environment of the release exists already, so that python3-venv is not needed.
    """
    if missing := list(_list_missing(has_environment=has_environment)):
        problems, remedies, kinds = zip(*missing, strict=True)
        raise AgentError(". ".join(problems), ". ".join(remedies), kinds[0], kinds=kinds)


def _list_missing(*, has_environment: bool) -> Iterator[Need]:
    if count_bits() != 64:
        problem = f"{read_system()} is a 32-bit system, for which NumPy and OpenCV have no wheels"
        yield Need(problem, "Put the 64-bit Raspberry Pi OS on it", "architecture")
    if not shutil.which("rsync"):
        yield Need("rsync is missing on the robot", "On the robot: sudo apt install rsync", "rsync")
    if not has_venv() and not has_environment:
        yield Need("python3-venv is missing on the robot", "On the robot: sudo apt install python3-venv", "venv")
    if need := _find_service_problem():
        yield need
    elif not _wait_for_user_manager():
        remedy = "For the reason, on the robot: systemctl --user status"
        yield Need("systemd runs no services of this user on the robot", remedy, "manager")


def require_lingering() -> None:
    """Turn lingering on. Raise AgentError if it stays off, because services then end with the ssh connection."""
    if problem := _find_service_problem():
        raise AgentError(*problem)


def _find_service_problem() -> Need | None:
    """Turn lingering on. Return why the services of this user cannot run without a login; None if they can."""
    if not shutil.which("systemctl"):
        return NO_SYSTEMD
    if enable_lingering():
        return None
    user = read_user()
    problem = f"lingering is off, so the services of {user} run only during a login"
    return Need(problem, f"On the robot: sudo loginctl enable-linger {user}", "linger")


def enable_lingering() -> bool:
    """Turn lingering on if the user may do that. Return whether lingering is on."""
    return is_lingering() or (_succeeds("loginctl", "--no-ask-password", "enable-linger") and is_lingering())


def _wait_for_user_manager() -> bool:
    for _ in range(MANAGER_TIMEOUT_S):
        if _succeeds("systemctl", "--user", "show", "--property=Version"):
            return True
        time.sleep(1)
    return False


def _succeeds(*command: str) -> bool:
    try:
        done = subprocess.run(  # noqa: S603
            command, env=build_environment(), capture_output=True, timeout=10, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0
