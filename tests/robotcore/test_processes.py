from __future__ import annotations

import os
import stat
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from robotcore.processes import describe_holders, describe_process, find_holders, is_same_device, list_open_files


@contextmanager
def run_script(script: str, *arguments: object) -> Iterator[subprocess.Popen[str]]:
    """Run a Python script in a process, which lives until the end of the ``with`` block."""
    command = [sys.executable, "-c", f"{script}\nprint('ready', flush=True)\nimport sys\nsys.stdin.read()"]
    with subprocess.Popen([*command, *map(str, arguments)], stdin=-1, stdout=-1, text=True) as process:
        try:
            assert process.stdout
            assert process.stdout.readline() == "ready\n"
            yield process
        finally:
            process.communicate()


OPENS = "import sys; file = open(sys.argv[1], 'rb')"
LOCKS = "import fcntl, os, sys; file = os.open(sys.argv[1], os.O_RDWR); fcntl.flock(file, fcntl.LOCK_EX)"


@pytest.fixture
def device(tmp_path: Path) -> Path:
    """A file that replaces a device."""
    (tmp_path / "device").touch()
    return tmp_path / "device"


@pytest.mark.parametrize("script", [OPENS, LOCKS])
def test_process_that_holds_a_device_is_found_by_each_name_of_it(device: Path, script: str) -> None:
    link = device.with_name("by-id")
    link.symlink_to(device)
    with run_script(script, device) as holder:
        assert find_holders(str(link)) == find_holders(str(device)) == [holder.pid]
        assert describe_holders(str(device)).startswith(f"process {holder.pid} (python")
    assert find_holders(str(device)) == []


def test_this_process_is_no_holder(device: Path) -> None:
    with device.open():
        assert str(device) in {file.link for file in list_open_files()}
        assert describe_holders(str(device)) == ""


def test_missing_device_has_no_holder(tmp_path: Path) -> None:
    assert find_holders(str(tmp_path / "missing")) == []


def test_device_is_found_by_a_name_that_its_holder_did_not_use(device: Path) -> None:
    """A hard link stands for the node of a device in a container."""
    node = device.with_name("node")
    node.hardlink_to(device)
    with run_script(OPENS, device) as holder:
        assert find_holders(str(node)) == [holder.pid]


OPENS_IN_CONTAINER = """
import ctypes, fcntl, os, struct, sys
CLONE_NEWNS, CLONE_NEWUSER, MS_REC, MS_PRIVATE = 0x20000, 0x10000000, 0x4000, 0x40000
TIOCSPTLCK, TIOCGPTN = 0x40045431, 0x80045430
libc = ctypes.CDLL(None)
is_apart = libc.unshare(CLONE_NEWUSER | CLONE_NEWNS) == 0
is_apart = is_apart and libc.mount(b"none", b"/", None, MS_REC | MS_PRIVATE, None) == 0
is_apart = is_apart and libc.mount(b"devpts", b"/dev/pts", b"devpts", 0, b"ptmxmode=0666") == 0
name = None
while is_apart and name != sys.argv[1]:
    master = os.open("/dev/pts/ptmx", os.O_RDWR | os.O_NOCTTY)
    fcntl.ioctl(master, TIOCSPTLCK, struct.pack("i", 0))
    name = "/dev/pts/%d" % struct.unpack("i", fcntl.ioctl(master, TIOCGPTN, bytes(4)))
    slave = os.open(name, os.O_RDWR | os.O_NOCTTY)
"""
"""Opens the pseudo-terminal of a path among those of a container, if this system lets a user make one."""


def test_pseudo_terminal_of_a_container_is_not_the_hosts_of_the_same_path() -> None:
    ends = os.openpty()
    path = os.ttyname(ends[1])
    with run_script(OPENS_IN_CONTAINER, path) as container:
        if path not in {file.link for file in list_open_files() if file.process == container.pid}:
            pytest.skip("this system lets no user mount in a namespace")
        assert find_holders(path) == []
    for end in ends:
        os.close(end)


def node(st_dev: int, st_ino: int, number: tuple[int, int], kind: int = stat.S_IFCHR) -> os.stat_result:
    return os.stat_result((kind, st_ino, st_dev, *[0] * 7), {"st_rdev": os.makedev(*number)})


@pytest.mark.parametrize(
    "first, second, is_same",
    [
        (node(5, 9, (188, 0)), node(5, 9, (188, 0)), True),
        (node(5, 9, (188, 0)), node(60, 2, (188, 0)), True),
        (node(5, 9, (188, 0)), node(5, 10, (188, 1)), False),
        (node(26, 6, (136, 3)), node(39, 6, (136, 3)), False),
        (node(26, 6, (136, 3)), node(26, 6, (136, 3)), True),
        (node(5, 9, (0, 0), stat.S_IFREG), node(6, 9, (0, 0), stat.S_IFREG), False),
    ],
    ids=["one-node", "two-nodes", "two-devices", "container", "one-terminal", "two-files"],
)
def test_devices_are_compared_by_number_and_terminals_by_node(
    first: os.stat_result, second: os.stat_result, *, is_same: bool
) -> None:
    assert is_same_device(first, second) == is_same


def test_guardian_is_named_by_its_task() -> None:
    with run_script("", "robotcore.safety.guardian.main") as guardian:
        assert describe_process(guardian.pid) == f"process {guardian.pid} (the guardian of a run)"
    assert describe_process(guardian.pid) == f"process {guardian.pid}"
