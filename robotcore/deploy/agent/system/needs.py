"""What a robot has to have for a release to be put on it, each with its remedy."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import suppress
from threading import Event

from robotcore.deploy.agent.system import facts, session
from robotcore.deploy.agent.telling import RefusalError

MANAGER_S = 5.0
"""In which a user's systemd comes up once lingering is on."""


def require(told: dict[str, object], *, has_environment: bool) -> None:
    """Look whether a release can be put here, by the facts; raises RefusalError with all that is missing.

    Lingering is turned on where that is allowed.
    """
    if missing := list(_missing(told, has_environment=has_environment)):
        faults, remedies, kinds = zip(*missing, strict=True)
        raise RefusalError(". ".join(faults), ". ".join(remedies), kinds[0])


def _missing(told: dict[str, object], *, has_environment: bool) -> Iterator[tuple[str, str, str]]:
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
    if not lingers():
        yield _no_linger()
    elif not comes_up():
        yield "systemd serves no user sessions on the robot", "There: systemctl --user status says why", "manager"


def require_lingering() -> None:
    """Raise RefusalError where the user's systemd would end with the connection."""
    if not lingers():
        raise RefusalError(*_no_linger())


def _no_linger() -> tuple[str, str, str]:
    user = session.user()
    fault = f"lingering is off: nothing of {user}'s runs while they are not logged in"
    return fault, f"There: sudo loginctl enable-linger {user}", "linger"


def lingers() -> bool:
    """Return whether lingering is on; it is turned on where this user may do so."""
    if not facts.is_lingering():
        with suppress(OSError, subprocess.TimeoutExpired):
            command = ["loginctl", "--no-ask-password", "enable-linger"]
            subprocess.run(command, capture_output=True, timeout=10, check=False)  # noqa: S603
    return facts.is_lingering()


def comes_up() -> bool:
    """Return whether systemd serves this user, at once or within a few seconds."""
    for _ in range(round(MANAGER_S)):
        if facts.has_user_manager():
            return True
        Event().wait(1)
    return False
