"""What a robot needs so that a release is kept running: the program, the units, a systemd that stays."""

from __future__ import annotations

import getpass
import subprocess
from pathlib import Path

from robotcore.deploy.aboard import program, sources, units
from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.telling import RefusalError

_LINGERING = Path("/var/lib/systemd/linger")
"""Has a file for each user whose systemd runs from boot to shutdown. Source: systemd's login/logind-user.c."""


def ensure(layout: Layout) -> None:
    """See to all that is needed; raises RefusalError where the user's systemd would end with the connection."""
    if not is_lingering() and not _lingers_now():
        user = getpass.getuser()
        raise RefusalError(
            f"the app would end when {user} logs out: {user} does not linger",
            f"On the robot, once: sudo loginctl enable-linger {user}",
            "linger",
        )
    program.install(layout, sources)
    units.install(layout)


def is_lingering() -> bool:
    """Whether this user's systemd runs without anybody being logged in."""
    return (_LINGERING / getpass.getuser()).exists()


def _lingers_now() -> bool:
    """Ask for lingering, which some systems grant to whoever asks for themselves; return whether it was granted."""
    command = ("loginctl", "--no-ask-password", "enable-linger")
    try:
        subprocess.run(command, capture_output=True, check=False)
    except FileNotFoundError:
        return False
    return is_lingering()
