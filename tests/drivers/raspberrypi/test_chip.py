"""The import of lgpio, the header's chip, and the holder of a GPIO."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from unittest.mock import Mock

import pytest

from drivers.raspberrypi import chip
from drivers.raspberrypi.chip import find_holder
from tests.drivers.raspberrypi.doctor.trees import create_chip
from tests.drivers.raspberrypi.lines import Lines

LEAVING = """
import os
before = dict(os.environ)
from drivers.raspberrypi.chip import load
lgpio = load()
assert load() is lgpio
assert dict(os.environ) == before
print(os.getcwd())
"""

AT_ONCE = """
import os, tempfile, time
from concurrent.futures import ThreadPoolExecutor
from drivers.raspberrypi import chip
from tests.drivers.raspberrypi.doctor.trees import create_chip

class Slow(tempfile.TemporaryDirectory):
    def __init__(self, **options):
        time.sleep(0.5)
        super().__init__(**options)

chip.TemporaryDirectory = Slow
before = dict(os.environ)
with ThreadPoolExecutor(2) as pool:
    assert len(set(map(id, pool.map(lambda _: chip.load(), range(2))))) == 1
assert dict(os.environ) == before
"""


def run(code: str, folder: Path, environment: dict[str, str]) -> str:
    command = [sys.executable, "-c", code]
    return subprocess.check_output(command, cwd=folder, env=environment, text=True, timeout=60).strip()


def test_importing_leaves_no_side_effects(tmp_path: Path) -> None:
    here, temporary = tmp_path / "here", tmp_path / "tmp"
    here.mkdir()
    temporary.mkdir()
    printed = run(LEAVING, here, {**Lines(tmp_path / "dev").environment, "TMPDIR": str(temporary)})
    assert Path(printed).samefile(here)
    assert not [*here.iterdir(), *temporary.iterdir()]


@pytest.mark.slow
def test_threads_can_import_at_the_same_time(tmp_path: Path) -> None:
    """The guardian opens the cutoffs of two motors in two threads, which import lgpio at the same time."""
    run(AT_ONCE, tmp_path, {**Lines(tmp_path / "dev").environment, "TMPDIR": str(tmp_path)})


@pytest.mark.parametrize(
    "revision, has_chip_4, number",
    [(0xA02082, True, 0), (0xC04170, False, 0), (0xC04170, True, 4)],
)
def test_the_header_is_on_chip_4_with_an_early_kernel_of_a_pi_5(
    revision: int, has_chip_4: bool, number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gpiozero.pins.local.get_pi_revision", lambda: revision)
    monkeypatch.setattr(Path, "exists", lambda file: has_chip_4 and file == Path("/dev/gpiochip4"))
    assert chip.find_chip_number(tmp_path) == number


@pytest.mark.parametrize(
    "chips, number",
    [
        ({0: "pinctrl-bcm2835", 1: "raspberrypi-exp-gpio"}, 0),
        ({0: "brcmstb-gpio", 3: "brcmstb-gpio", 4: "pinctrl-rp1"}, 4),
        ({0: "pinctrl-rp1", 4: "brcmstb-gpio"}, 0),
        ({11: "brcmstb-gpio", 15: "pinctrl-rp1"}, 15),
    ],
)
def test_the_headers_chip_is_found_by_its_driver(chips: dict[int, str], number: int, tmp_path: Path) -> None:
    for each, driver in chips.items():
        create_chip(tmp_path, each, driver)
    assert chip.find_chip_number(tmp_path) == number


HANDLE = "anon_inode:gpio-line"


def add_process(root: Path, number: int, name: str, *handles: str, link: str = HANDLE) -> None:
    """Add a process to a folder in place of the root of the file system."""
    process = root / "proc" / str(number)
    for folder in ("fd", "fdinfo"):
        process.joinpath(folder).mkdir(parents=True)
    process.joinpath("comm").write_text(f"{name}\n")
    process.joinpath("cmdline").write_text(f"/usr/bin/{name}\0")
    for at, lines in enumerate(handles, start=3):
        process.joinpath("fd", str(at)).symlink_to(link)
        process.joinpath("fdinfo", str(at)).write_text(f"pos:\t0\nflags:\t02000002\nmnt_id:\t15\nino:\t11\n{lines}")


def handle(*gpios: int, chip: str = "gpiochip0") -> str:
    return f"gpio-chip:\t{chip}\n" + "".join(f"gpio-line:\t{gpio}\n" for gpio in gpios)


@pytest.mark.parametrize(
    "gpio, processes, holder",
    [
        (17, {77: [handle(4)], 1234: [handle(27), handle(16, 17)]}, "process 1234 (python3)"),
        (7, {77: [handle(17)]}, "an unknown holder"),
        (17, {77: [handle(17, chip="gpiochip1")]}, "an unknown holder"),
        (17, {1234: [handle(17)], 1240: [handle(17)]}, "process 1234 (python3) or process 1240 (python3)"),
        (17, {77: [""], 1234: ["", ""]}, "an unknown holder"),
    ],
    ids=["held", "another line", "another chip", "forks", "old kernel"],
)
def test_the_processes_with_a_handle_of_the_line_are_named(
    gpio: int, processes: dict[int, list[str]], holder: str, tmp_path: Path
) -> None:
    add_process(tmp_path, 1, "systemd")
    add_process(tmp_path, 1300, "bash", "", link="/dev/pts/0")
    for number, handles in processes.items():
        add_process(tmp_path, number, "python3", *handles)
    assert find_holder(gpio, tmp_path) == holder


def test_a_chip_with_two_names_is_found_by_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A Pi 5 has /dev/gpiochip4 as a link to /dev/gpiochip0."""
    tmp_path.joinpath("dev").mkdir()
    tmp_path.joinpath("dev/gpiochip4").symlink_to("gpiochip0")
    monkeypatch.setattr(chip, "find_chip_number", lambda _: 4)
    add_process(tmp_path, 77, "gpioset", handle(17))
    assert find_holder(17, tmp_path) == "process 77 (gpioset)"


def test_a_process_of_another_user_is_skipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    add_process(tmp_path, 77, "gpioset", handle(17))
    monkeypatch.setattr(Path, "readlink", Mock(side_effect=PermissionError))
    assert find_holder(17, tmp_path) == "an unknown holder"


def test_a_holder_in_the_kernel_has_a_label(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A bus that config.txt has switched on has no process."""
    chip = tmp_path / "dev" / "gpiochip0"
    chip.parent.mkdir()
    chip.touch()

    def ioctl(file: object, request: int, info: bytearray) -> int:
        assert (request, len(info), int.from_bytes(info[64:68], "little")) == (0xC100B405, 256, 8)
        info[32:41] = b"spi0 CS0\0"
        return 0

    monkeypatch.setattr("fcntl.ioctl", ioctl)
    assert find_holder(8, tmp_path) == "an unknown holder, as 'spi0 CS0'"
