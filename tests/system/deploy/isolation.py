"""A control group for what is booted, so that of two machines neither takes the other's services for its own."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path

from tests.system import needs

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


INSIDE = "host0"


@dataclass(frozen=True)
class Network:
    """A network namespace that its holder keeps, whoever boots and dies in it, and the target's address in it.

    It has no route but the one to the desk: no package registry can be reached from there.
    """

    holder: int
    address: str

    @property
    def entering(self) -> list[str]:
        """What to put before a command that is to run in it."""
        return ["nsenter", f"--net=/proc/{self.holder}/ns/net"]


@contextmanager
def network() -> Iterator[Network]:
    """Make one that ends with this process; raises NotRunError where it cannot be made."""
    holding = [*needs.ENDING_WITH_US, "unshare", "--net", "sh", "-c", "echo; exec sleep infinity"]
    with subprocess.Popen(holding, stdout=subprocess.PIPE) as holder:
        try:
            assert holder.stdout
            if not holder.stdout.readline():
                raise needs.NotRunError("needs network namespaces; a privileged container has them")
            yield _joined(holder.pid)
        finally:
            holder.kill()


def _joined(holder: int) -> Network:
    """Lay a wire between the desk and a namespace, of link-local addresses that nobody else has been given."""
    third, fourth = holder // 64 % 254 + 1, holder % 64 * 4
    desk, target = f"169.254.{third}.{fourth + 1}", f"169.254.{third}.{fourth + 2}"
    outside = f"rover{holder}"
    made = Network(holder, target)
    for change in (
        ["ip", "link", "add", outside, "type", "veth", "peer", "name", INSIDE, "netns", str(holder)],
        ["ip", "address", "add", f"{desk}/30", "dev", outside],
        ["ip", "link", "set", outside, "up"],
        [*made.entering, "ip", "address", "add", f"{target}/30", "dev", INSIDE],
        [*made.entering, "ip", "link", "set", INSIDE, "up"],
        [*made.entering, "ip", "link", "set", "lo", "up"],
    ):
        run = subprocess.run(change, capture_output=True, text=True, check=False)
        if run.returncode:
            raise needs.NotRunError(f"needs a virtual network, and ip said: {needs.last_line(run.stderr)}")
    return made
