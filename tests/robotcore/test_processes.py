from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from robotcore.processes import describe_holders, describe_process, find_holders, list_open_files


@contextmanager
def running(script: str, *arguments: object) -> Iterator[subprocess.Popen[str]]:
    """Run a Python script until it has written a line; it is to end with its standard input."""
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
    """A file in the place of a device."""
    (tmp_path / "device").touch()
    return tmp_path / "device"


@pytest.mark.parametrize("script", [OPENS, LOCKS])
def test_process_that_holds_a_device_is_found_by_each_name_of_it(device: Path, script: str) -> None:
    link = device.with_name("by-id")
    link.symlink_to(device)
    with running(script, device) as holder:
        assert find_holders(str(link)) == find_holders(str(device)) == [holder.pid]
        assert describe_holders(str(device)).startswith(f"process {holder.pid} (python")
    assert find_holders(str(device)) == []


def test_this_process_is_no_holder(device: Path) -> None:
    with device.open():
        assert str(device) in {file.link for file in list_open_files()}
        assert describe_holders(str(device)) == ""


def test_missing_device_has_no_holder(tmp_path: Path) -> None:
    assert find_holders(str(tmp_path / "missing")) == []


def test_guardian_is_named_by_its_task() -> None:
    with running("", "robotcore.safety.guardian.main") as guardian:
        assert describe_process(guardian.pid) == f"process {guardian.pid} (the guardian of a run)"
    assert describe_process(guardian.pid) == f"process {guardian.pid}"
