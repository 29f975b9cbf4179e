"""The isolation of a robot: a control group and a network of its own."""

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
"""The folders that may hold control groups: the unified hierarchy, and those beside version 1."""

_NUMBERS = count()

JOIN_GROUP = 'for file; do [ "$file" = -- ] && break; echo $$ > "$file"; shift; done; shift; exec "$@"'


@contextmanager
def make_group() -> Iterator[list[str]]:
    """Make a control group, and yield the prefix of a command that runs in it. The group is deleted at the end.

    Without it, the systemd of one robot would see the services of another.
    """
    name = f"robotcore-{os.getpid()}-{next(_NUMBERS)}"
    groups = [folder / name for folder in HIERARCHIES if (folder / "cgroup.procs").is_file()]
    for group in groups:
        group.mkdir()
    try:
        yield ["sh", "-c", JOIN_GROUP, "join", *(str(group / "cgroup.procs") for group in groups), "--"]
    finally:
        for group in groups:
            _remove(group)


def _remove(group: Path) -> None:
    for folder, _, _ in os.walk(group, topdown=False):
        with suppress(OSError):  # a process in it has not ended yet
            Path(folder).rmdir()


ROBOT_INTERFACE = "host0"


@dataclass(frozen=True)
class Network:
    """A network namespace for a robot. Its only route leads to the client, so it reaches no package registry."""

    holder: int
    """The process that keeps the namespace while robots boot and end in it."""
    address: str
    """The robot's address in the network."""

    @property
    def command_prefix(self) -> list[str]:
        """The prefix of a command line that runs in the network."""
        return ["nsenter", f"--net=/proc/{self.holder}/ns/net"]


@contextmanager
def make_network() -> Iterator[Network]:
    """Make a network that ends with this process; raises NotRunError if the system does not allow it."""
    holding = [*needs.ENDING_WITH_US, "unshare", "--net", "sh", "-c", "echo; exec sleep infinity"]
    with subprocess.Popen(holding, stdout=subprocess.PIPE) as holder:
        try:
            assert holder.stdout
            if not holder.stdout.readline():
                raise needs.NotRunError("needs network namespaces; a privileged container has them")
            yield _connect(holder.pid)
        finally:
            holder.kill()


def _connect(holder: int) -> Network:
    """Connect the client and a namespace by a virtual cable, with unique link-local addresses."""
    third, fourth = holder // 64 % 254 + 1, holder % 64 * 4
    client, target = f"169.254.{third}.{fourth + 1}", f"169.254.{third}.{fourth + 2}"
    outside = f"rover{holder}"
    made = Network(holder, target)
    for change in (
        ["ip", "link", "add", outside, "type", "veth", "peer", "name", ROBOT_INTERFACE, "netns", str(holder)],
        ["ip", "address", "add", f"{client}/30", "dev", outside],
        ["ip", "link", "set", outside, "up"],
        [*made.command_prefix, "ip", "address", "add", f"{target}/30", "dev", ROBOT_INTERFACE],
        [*made.command_prefix, "ip", "link", "set", ROBOT_INTERFACE, "up"],
        [*made.command_prefix, "ip", "link", "set", "lo", "up"],
    ):
        run = subprocess.run(change, capture_output=True, text=True, check=False)
        if run.returncode:
            raise needs.NotRunError(f"needs a virtual network, but ip failed: {needs.last_line(run.stderr)}")
    return made
