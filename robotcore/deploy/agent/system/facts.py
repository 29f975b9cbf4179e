"""What a robot is, as far as a deploy leans on it."""

from __future__ import annotations

import grp
import os
import platform
import shutil
import subprocess
import sys
from contextlib import suppress
from datetime import datetime, timezone
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.system import session
from robotcore.deploy.agent.system.disk import free_bytes

GROUPS = ("gpio", "i2c", "spi", "video")
"""Who may use a Raspberry Pi's devices."""

LINGERING = Path("/var/lib/systemd/linger")
"""Has a file for each user whose services run without them being logged in. Source: systemd's loginctl."""

MODEL = Path("/proc/device-tree/model")


def facts(layout: Layout) -> dict[str, Any]:
    """Return what the desk is told; all of it is found without root, and nothing fails where something is missing."""
    libc, libc_version = platform.libc_ver()
    return {
        "host": platform.node(),
        "user": session.user(),
        "home": str(layout.home),
        "system": system(),
        "model": model(),
        "machine": platform.machine(),
        "bits": bits(),
        "python": platform.python_version(),
        "libc": libc,
        "libc_version": libc_version,
        "free_bytes": free_bytes(layout.root),
        "has_rsync": bool(shutil.which("rsync")),
        "has_venv": has_venv(),
        "has_user_manager": has_user_manager(),
        "is_lingering": is_lingering(),
        "groups": groups(),
        "reads_journal": reads_journal(),
        "time": datetime.now(timezone.utc).isoformat(timespec="seconds"),
    }


def system() -> str:
    """Return the operating system's name."""
    with suppress(OSError):
        return platform.freedesktop_os_release()["PRETTY_NAME"]
    return platform.system()


def model() -> str:
    """Return which board it is; empty where none tells."""
    with suppress(OSError):
        return MODEL.read_text(errors="replace").rstrip("\0")
    return ""


def bits() -> int:
    """Return the bits of programs here, whatever the kernel has."""
    return 64 if sys.maxsize > 2**32 else 32


def has_venv() -> bool:
    """Return whether Python can make environments with pip in them; Debian has that apart."""
    return bool(find_spec("venv") and find_spec("ensurepip"))


def is_lingering() -> bool:
    """Return whether this user's services run without them being logged in."""
    return (LINGERING / session.user()).exists()


def has_user_manager() -> bool:
    """Return whether systemd serves this user."""
    return _answers("systemctl", "--user", "show", "--property=Version")


def reads_journal() -> bool:
    """Return whether this user may read what their services say."""
    return _answers("journalctl", "--user", "--lines=0", "--quiet")


def groups() -> dict[str, bool]:
    """Return of those groups that there are here whether the user is in them."""
    mine = {*os.getgroups(), os.getgid()}
    return {group.gr_name: group.gr_gid in mine for group in grp.getgrall() if group.gr_name in GROUPS}


def _answers(*command: str) -> bool:
    try:
        asked = subprocess.run(  # noqa: S603
            command, env=session.environment(), capture_output=True, timeout=10, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return asked.returncode == 0
