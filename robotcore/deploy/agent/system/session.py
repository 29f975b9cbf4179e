"""Whose call this is, and what lasts until a reboot for them."""

from __future__ import annotations

import os
import pwd
from pathlib import Path


def user() -> str:
    """Return who is logged in, by the system's word: the environment may have another one."""
    return pwd.getpwuid(os.getuid()).pw_name


def runtime() -> Path:
    """Return the folder of what lasts until a reboot, in which systemd listens too.

    A login that does not know it has one all the same, where the user lingers.
    """
    return Path(os.environ.get("XDG_RUNTIME_DIR") or f"/run/user/{os.getuid()}")


def environment() -> dict[str, str]:
    """Return what a program needs to find the user's systemd and journal, and to speak so that it is understood."""
    return {**os.environ, "XDG_RUNTIME_DIR": str(runtime()), "LC_ALL": "C.UTF-8", "SYSTEMD_COLORS": "0"}
