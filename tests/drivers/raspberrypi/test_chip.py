"""The holder of a GPIO, by the kernel's files."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from drivers.raspberrypi import chip as holders
from drivers.raspberrypi.chip import find_holder

HANDLE = "anon_inode:gpio-line"


class Processes:
    """A folder in place of /proc."""

    def __init__(self, root: Path) -> None:
        self.root = root
        (root / "proc").mkdir()

    def add(self, number: int, name: str, *handles: str, link: str = HANDLE) -> None:
        process = self.root / "proc" / str(number)
        for folder in ("fd", "fdinfo"):
            process.joinpath(folder).mkdir(parents=True)
        process.joinpath("comm").write_text(f"{name}\n")
        process.joinpath("cmdline").write_text(f"/usr/bin/{name}\0")
        for at, lines in enumerate(handles, start=3):
            process.joinpath("fd", str(at)).symlink_to(link)
            process.joinpath("fdinfo", str(at)).write_text(f"pos:\t0\nflags:\t02000002\nmnt_id:\t15\nino:\t11\n{lines}")


def handle(*gpios: int, chip: str = "gpiochip0") -> str:
    return f"gpio-chip:\t{chip}\n" + "".join(f"gpio-line:\t{gpio}\n" for gpio in gpios)


@pytest.fixture
def processes(tmp_path: Path) -> Processes:
    return Processes(tmp_path)


def test_the_process_with_a_handle_of_the_line_is_named(processes: Processes) -> None:
    processes.add(1, "systemd")
    processes.add(77, "gpioset", handle(4))
    processes.add(1234, "python3", handle(27), handle(16, 17))
    assert find_holder(17, processes.root) == "process 1234 (python3)"
    assert find_holder(7, processes.root) == "an unknown holder"


def test_the_same_line_of_another_chip_is_another_line(processes: Processes) -> None:
    processes.add(77, "gpioset", handle(17, chip="gpiochip1"))
    assert find_holder(17, processes.root) == "an unknown holder"


def test_a_chip_with_two_names_is_found_by_its_own(processes: Processes, monkeypatch: pytest.MonkeyPatch) -> None:
    """A Pi 5 has /dev/gpiochip4 as a link to /dev/gpiochip0."""
    processes.root.joinpath("dev").mkdir()
    processes.root.joinpath("dev/gpiochip0").touch()
    processes.root.joinpath("dev/gpiochip4").symlink_to("gpiochip0")
    monkeypatch.setattr(holders, "find_chip_number", lambda _: 4)
    processes.add(77, "gpioset", handle(17))
    assert find_holder(17, processes.root) == "process 77 (gpioset)"


def test_all_forks_that_share_a_line_are_named(processes: Processes) -> None:
    processes.add(1234, "python3", handle(17))
    processes.add(1240, "python3", handle(17))
    assert find_holder(17, processes.root) == "process 1234 (python3) or process 1240 (python3)"


def test_with_an_old_kernel_every_process_with_a_handle_is_named(processes: Processes) -> None:
    processes.add(77, "gpioset", "")
    processes.add(1234, "python3", "", "")
    processes.add(1300, "bash", "", link="/dev/pts/0")
    assert find_holder(17, processes.root) == "perhaps process 77 (gpioset) or process 1234 (python3)"


def test_this_process_is_not_named(processes: Processes) -> None:
    processes.add(os.getpid(), "python3", "")
    assert find_holder(17, processes.root) == "an unknown holder"


def test_a_process_of_another_user_is_skipped(processes: Processes, monkeypatch: pytest.MonkeyPatch) -> None:
    processes.add(77, "gpioset", handle(17))
    processes.add(1234, "python3", handle(17))
    readlink = Path.readlink

    def refuse(file: Path) -> Path:
        if "77" in file.parts:
            raise PermissionError
        return readlink(file)

    monkeypatch.setattr(Path, "readlink", refuse)
    assert find_holder(17, processes.root) == "process 1234 (python3)"


def test_a_holder_in_the_kernel_has_a_label(processes: Processes, monkeypatch: pytest.MonkeyPatch) -> None:
    """A bus that config.txt has switched on has no process."""
    chip = processes.root / "dev" / "gpiochip0"
    chip.parent.mkdir()
    chip.touch()

    def ioctl(file: object, request: int, info: bytearray) -> int:
        assert (request, len(info), int.from_bytes(info[64:68], "little")) == (0xC100B405, 256, 8)
        info[32:41] = b"spi0 CS0\0"
        return 0

    monkeypatch.setattr("fcntl.ioctl", ioctl)
    assert find_holder(8, processes.root) == "an unknown holder, as 'spi0 CS0'"


def test_a_real_process_with_a_handle_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "handle"
    monkeypatch.setattr(holders, "LINE", str(file))
    waiting = [sys.executable, "-c", "input()"]
    with file.open("w") as held, subprocess.Popen(waiting, stdin=subprocess.PIPE, stdout=held) as other:
        assert str(other.pid) in find_holder(17)
        other.communicate(b"\n")
    assert find_holder(17) == "an unknown holder"
