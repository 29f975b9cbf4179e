"""A control group for what is booted, so that of two machines neither takes the other's services for its own."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path

MOUNTED = Path("/sys/fs/cgroup")
HIERARCHIES = (MOUNTED, MOUNTED / "unified", MOUNTED / "systemd")
"""Where systemd keeps its groups: the one hierarchy, or with version 1 beside it, these two."""

_NUMBERS = count()

JOINING = 'for file; do [ "$file" = -- ] && break; echo $$ > "$file"; shift; done; shift; exec "$@"'


@contextmanager
def own_group() -> Iterator[list[str]]:
    """Make a group; gives what to put before a command that is to run in it. All of it has ended when this is left."""
    name = f"robotcore-{os.getpid()}-{next(_NUMBERS)}"
    groups = [folder / name for folder in HIERARCHIES if (folder / "cgroup.procs").is_file()]
    for group in groups:
        group.mkdir()
    try:
        yield ["sh", "-c", JOINING, "joining", *(str(group / "cgroup.procs") for group in groups), "--"]
    finally:
        for group in groups:
            _remove(group)


def _remove(group: Path) -> None:
    for folder, _, _ in os.walk(group, topdown=False):
        with suppress(OSError):  # somebody in it has not quite ended: the kernel is told no more than that
            Path(folder).rmdir()
