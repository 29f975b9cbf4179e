"""Checks of the board itself: model, operating system, power supply, clock and disk."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

from robotcore.hal.check_finding import Finding

MODEL = "proc/device-tree/model"
BITS = {1: 32, 2: 64}
"""The width of pointers in bits, by the fifth byte of an ELF file (EI_CLASS). Source: elf(5)."""


def read_model(root: Path) -> str | None:
    """Return the board's model, such as ``Raspberry Pi 5 Model B Rev 1.0``; None if the kernel reports none."""
    try:
        return read_text(root / MODEL)
    except OSError:
        return None


def is_raspberry_pi(root: Path = Path("/")) -> bool:
    """Return whether this board is a Raspberry Pi of any model."""
    return (read_model(root) or "").startswith("Raspberry Pi")


def check_board(root: Path) -> Iterator[Finding]:
    """Report the board's model, and check that this Python has 64 bits, which NumPy and OpenCV need."""
    bits = read_python_bits(root)
    message = f"{read_model(root)}, {bits}-bit Python"
    if bits == 64:
        yield Finding.ok("board", message, kind="board")
    else:
        remedy = "Install the 64-bit Raspberry Pi OS: NumPy and OpenCV are not built for 32 bits"
        yield Finding.warning("board", message, remedy, kind="python-32-bit")


def read_python_bits(root: Path) -> int:
    """Return the pointer width of this Python program in bits, which may differ from the kernel's."""
    with (root / "proc/self/exe").open("rb") as program:
        return BITS[program.read(5)[4]]


TESTED = ("bookworm", "trixie")
"""The releases of Raspberry Pi OS whose lgpio and picamera2 were tested with robotcore."""


def check_release(root: Path) -> Iterator[Finding]:
    """Check that the operating system is a tested release of Raspberry Pi OS."""
    about = parse_fields(read_text(root / "etc/os-release"))
    message = about.get("PRETTY_NAME", "a system without a name")
    if about.get("VERSION_CODENAME") in TESTED:
        yield Finding.ok("system", message, kind="system")
    else:
        remedy = f"Install Raspberry Pi OS {' or '.join(name.capitalize() for name in TESTED)}, 64-bit"
        yield Finding.warning("system", f"{message} is not tested", remedy, kind="system-untested")


def parse_fields(text: str) -> dict[str, str]:
    """Return the fields of an os-release file, without quotes. Source: os-release(5)."""
    pairs = (line.partition("=") for line in text.splitlines() if "=" in line and not line.startswith("#"))
    return {key.strip(): value.strip().strip("\"'") for key, _, value in pairs}


POWER = "power"
VCGENCMD = "usr/bin/vcgencmd"
ANSWER_S = 5.0
LOW, CAPPED, THROTTLED, WARM = 0, 1, 2, 3
POWER_BITS = {
    LOW: "the voltage is low",
    CAPPED: "the clock is capped",
    THROTTLED: "the chip is throttled",
    WARM: "the chip is at its soft temperature limit",
}
"""The bits of vcgencmd's result for present problems, and their descriptions. The bit 16 places higher is set if the
problem occurred at any time since the start.

Source: https://www.raspberrypi.com/documentation/computers/os.html#get_throttled."""

SINCE_START = 16
STRONGER = "Use a stronger supply and a short, thick cable, and a separate battery for the motors"
COOLER = "Let air reach the chip, or put a cooler on it"


def check_power(root: Path, ask: Callable[[Path], str] | None = None) -> Iterator[Finding]:
    """Check the supply voltage and the chip's temperature, now and since the board's start.

    ask: runs the program vcgencmd, and returns its output, such as ``throttled=0x50005``. Tests replace the function.
    """
    word = int((ask or _ask_vcgencmd)(root / VCGENCMD).strip().rpartition("=")[2], 16)
    now, before = _power_bits(word), _power_bits(word >> SINCE_START)
    if not now | before:
        yield Finding.ok(POWER, "no problem with voltage or temperature since the start", kind="power-ok")
    if now:
        yield _power_finding(Finding.error if LOW in now else Finding.warning, f"{_format_bits(now)} now", now, "now")
    if past := before - now:
        yield _power_finding(Finding.warning, f"earlier, since the start: {_format_bits(past)}", past, "earlier")


def _power_bits(word: int) -> set[int]:
    return {bit for bit in POWER_BITS if word >> bit & 1}


def _format_bits(bits: set[int]) -> str:
    return ", ".join(POWER_BITS[bit] for bit in sorted(bits))


def _power_finding(make: Callable[..., Finding], message: str, bits: set[int], when: str) -> Finding:
    cause, remedy = ("voltage-low", STRONGER) if LOW in bits else ("throttled", COOLER)
    return make(POWER, message, remedy, kind=f"{cause}-{when}")


def _ask_vcgencmd(program: Path) -> str:
    command = [str(program), "get_throttled"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=ANSWER_S, check=False)  # noqa: S603
    if done.returncode:
        raise OSError(f"vcgencmd failed: {(done.stderr or done.stdout).strip()}")
    return done.stdout


CLOCK = "clock"
SYNCHRONISED = "run/systemd/timesync/synchronized"
"""The file that systemd-timesyncd creates at the first answer of a time server.

Source: systemd-timesyncd.service(8)."""

TIMEDATECTL = "usr/bin/timedatectl"


def check_clock(root: Path, ask: Callable[[Path], str] | None = None) -> Iterator[Finding]:
    """Check that a time server has set the clock. Otherwise the dates of recordings are wrong.

    ask: runs the program timedatectl, and returns ``yes`` or ``no``. timedatectl also detects time programs other than
        systemd-timesyncd. Tests replace the function.
    """
    if (root / SYNCHRONISED).exists() or (ask or _ask_timedatectl)(root / TIMEDATECTL).strip() == "yes":
        yield Finding.ok(CLOCK, "set by a time server", kind="clock-synchronised")
    else:
        message = "no time server has answered since the start: the dates of recordings are wrong"
        yield Finding.warning(
            CLOCK,
            message,
            "Connect the board to a network once, and run sudo timedatectl set-ntp true",
            kind="clock-unsynchronised",
        )


def _ask_timedatectl(program: Path) -> str:
    command = [str(program), "show", "--property=NTPSynchronized", "--value"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=ANSWER_S, check=False)  # noqa: S603
    if done.returncode:
        raise OSError(f"timedatectl failed: {done.stderr.strip()}")
    return done.stdout


DISK = "disk"
ENOUGH_GB, LEAST_GB = 2.0, 0.2
"""The doctor warns if less than `ENOUGH_GB` gigabytes are free, and reports an error below `LEAST_GB`. A recording with
pictures takes up to a gigabyte an hour. Without free space the system itself fails."""

DISK_REMEDY = "Delete old recordings; sudo apt clean"


def check_disk(root: Path) -> Iterator[Finding]:
    """Check the free space on the system's disk."""
    free = shutil.disk_usage(root).free / 1e9
    message = f"{free:.1f} GB are free"
    if free < LEAST_GB:
        yield Finding.error(DISK, message, DISK_REMEDY, kind="disk-full")
    elif free < ENOUGH_GB:
        yield Finding.warning(DISK, message, DISK_REMEDY, kind="disk-low")
    else:
        yield Finding.ok(DISK, message, kind="disk-ok")


def read_text(file: Path) -> str:
    """Return a file's text; raises OSError. The result has no NUL, which ends strings of the device tree."""
    return file.read_text(encoding="utf-8", errors="replace").strip("\0 \n")
