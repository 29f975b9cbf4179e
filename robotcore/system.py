"""The kinds of operating system, and the error for a feature that this one cannot have.

The other modules use the two constants here, and do not compare the system's name themselves. A module that needs one
function or signal only may test whether Python has it.
"""

from __future__ import annotations

import sys

from robotcore.errors import UnsupportedSystemError

try:
    import fcntl
except ModuleNotFoundError:
    fcntl = None  # type: ignore[assignment]

HAS_POSIX = fcntl is not None
"""Whether the system has the processes, signals, terminals and file locks of POSIX. Windows has not."""

LOOPBACK = "127.0.0.1"
"""The address of the loopback interface, which only programs on this machine reach."""

IS_LINUX = HAS_POSIX and sys.platform == "linux"
"""Whether the system has the device files and the ``/proc`` of Linux."""


def require_posix(feature: str, needed: str, remedy: str) -> None:
    """Raise UnsupportedSystemError on a system without POSIX. The parameters are those of the error."""
    if not HAS_POSIX:
        raise UnsupportedSystemError(feature, needed, remedy)


def require_linux(feature: str, needed: str, remedy: str) -> None:
    """Raise UnsupportedSystemError on another system than Linux. The parameters are those of the error."""
    if not IS_LINUX:
        raise UnsupportedSystemError(feature, needed, remedy)
