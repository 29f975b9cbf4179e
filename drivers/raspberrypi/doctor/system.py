"""Checks of the board, the operating system, the library of the pins, power supply, clock and disk."""

from __future__ import annotations

import platform
import shutil
import struct
import subprocess
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from drivers.raspberrypi.chip import find_header_driver
from drivers.raspberrypi.pins import open_pins
from robotcore.errors import BackendError
from robotcore.hal.check_finding import Finding


def read_text(file: Path) -> str:
    """Return a file's text; raises OSError. The result has no NUL, which ends strings of the device tree."""
    return file.read_text(encoding="utf-8", errors="replace").strip("\0 \n")


def read_model(root: Path) -> str:
    """Return the board's model, such as ``Raspberry Pi 5 Model B Rev 1.0``; an empty text without a model."""
    try:
        return read_text(root / "proc/device-tree/model")
    except OSError:
        return ""


def is_raspberry_pi(root: Path = Path("/")) -> bool:
    """Return whether this board is a Raspberry Pi of any model."""
    return read_model(root).startswith("Raspberry Pi")


def check_board(root: Path) -> Iterator[Finding]:
    """Report the board's model, and check that this Python has 64 bits, which NumPy and OpenCV need."""
    bits = struct.calcsize("P") * 8  # a kernel of 64 bits may run programs of 32 bits
    message = f"{read_model(root)}, {bits}-bit Python"
    if bits == 64:
        yield Finding.ok("board", message, kind="board")
    else:
        remedy = "Install the 64-bit Raspberry Pi OS: NumPy and OpenCV are not built for 32 bits"
        yield Finding.warning("board", message, remedy, kind="python-32-bit")


TESTED = ("bookworm", "trixie")
"""The releases of Raspberry Pi OS whose lgpio and picamera2 were tested with robotcore."""


def check_release() -> Iterator[Finding]:
    """Check that the operating system is a tested release of Raspberry Pi OS."""
    about = platform.freedesktop_os_release()
    if about.get("VERSION_CODENAME") in TESTED:
        yield Finding.ok("system", about["PRETTY_NAME"], kind="system")
    else:
        remedy = f"Install Raspberry Pi OS {' or '.join(name.capitalize() for name in TESTED)}, 64-bit"
        yield Finding.warning("system", f"{about['PRETTY_NAME']} is not tested", remedy, kind="system-untested")


OLDEST_GPIOZERO = (2, 0, 1)
"""The oldest supported version of gpiozero, the same as in the extra ``pi`` of pyproject.toml."""


def check_library() -> Iterator[Finding]:
    """Check that lgpio and gpiozero are installed and work. No pin is changed."""
    subject, lgpio, gpiozero = "pin factory", find_version("lgpio"), find_version("gpiozero") or "0"
    if tuple(int(part) for part in gpiozero.split(".")[:3] if part.isdecimal()) < OLDEST_GPIOZERO:
        remedy = "pip install --upgrade 'gpiozero>=2.0.1'"
        yield Finding.error(subject, f"gpiozero {gpiozero} is too old", remedy, kind="gpiozero-too-old")
    try:
        open_pins().close()
    except BackendError as error:
        problem, _, remedy = str(error).partition(". ")
        yield Finding.error(subject, problem, remedy, kind="pin-factory-fails")
    else:
        yield Finding.ok(subject, f"lgpio {lgpio}".strip() + f", under gpiozero {gpiozero}", kind="pin-factory-ok")


def find_version(package: str) -> str:
    """Return the version of an installed package; an empty text if it is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


PARAMETERS = "sys/module/{module}/parameters/persist_gpio_outputs"
ANY_CONTROLLER = "pinctrl_*"
PERSISTENCE_REMEDY = (
    "Add the line dtparam=strict_gpiod to /boot/firmware/config.txt and restart; "
    "and pull the motor board's enable or standby pin down by a resistor of 10 kΩ"
)


def check_persistence(root: Path) -> Iterator[Finding]:
    """Check that the kernel releases the outputs of a killed program. Otherwise its motors continue to turn.

    Only the kernel driver of the header's GPIO chip is checked. A kernel may have GPIO drivers for other boards too.
    """
    subject, module = "killed runs", (find_header_driver(root) or ANY_CONTROLLER).replace("-", "_")
    settings = {file.parts[-3]: read_text(file) for file in sorted(root.glob(PARAMETERS.format(module=module)))}
    if keeping := [module for module, value in settings.items() if value.upper() in ("Y", "1")]:
        message = (
            "GPIO outputs keep their level after their program was killed "
            f"({', '.join(keeping)}.persist_gpio_outputs=Y). Then only the guardian stops a turning motor"
        )
        yield Finding.warning(subject, message, PERSISTENCE_REMEDY, kind="outputs-persist")
    elif settings:
        yield Finding.ok(subject, "the kernel releases the outputs of a killed program", kind="outputs-released")
    else:
        message = "this kernel has no parameter persist_gpio_outputs: it may be too old"
        yield Finding.unchecked(subject, message, f"sudo apt full-upgrade. {PERSISTENCE_REMEDY}")


POWER_BITS = (
    "the voltage is low",
    "the clock is capped",
    "the chip is throttled",
    "the chip is at its soft temperature limit",
)
"""The lowest bits of vcgencmd's result, for present problems. The bit 16 places higher is set if the problem occurred
at any time since the start.

Source: https://www.raspberrypi.com/documentation/computers/os.html#get_throttled."""

SINCE_START = 16
STRONGER = "Use a stronger supply and a short, thick cable, and a separate battery for the motors"
COOLER = "Let air reach the chip, or put a cooler on it"


def check_power(root: Path) -> Iterator[Finding]:
    """Check the supply voltage and the chip's temperature, now and since the board's start."""
    answer = _run(root / "usr/bin/vcgencmd", "get_throttled")  # such as throttled=0x50005
    word = int(answer.rpartition("=")[2], 16)
    now, before = _list_problems(word), _list_problems(word >> SINCE_START)
    if not now and not before:
        yield Finding.ok("power", "no problem with voltage or temperature since the start", kind="power-ok")
    past = [problem for problem in before if problem not in now]
    for problems, when in ((now, "now"), (past, "earlier")):
        if problems:
            is_low, listed = POWER_BITS[0] in problems, ", ".join(problems)
            message = f"{listed} now" if when == "now" else f"earlier, since the start: {listed}"
            build = Finding.error if is_low and when == "now" else Finding.warning
            cause = "voltage-low" if is_low else "throttled"
            yield build("power", message, STRONGER if is_low else COOLER, kind=f"{cause}-{when}")


def _list_problems(word: int) -> list[str]:
    return [problem for bit, problem in enumerate(POWER_BITS) if word >> bit & 1]


def _run(program: Path, *arguments: str) -> str:
    done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=5.0, check=False)  # noqa: S603
    if done.returncode:
        raise OSError(f"{program.name} failed: {(done.stderr or done.stdout).strip()}")
    return done.stdout.strip()


SYNCHRONISED = "run/systemd/timesync/synchronized"
"""The file that systemd-timesyncd creates at the first answer of a time server.

Source: systemd-timesyncd.service(8)."""


def check_clock(root: Path) -> Iterator[Finding]:
    """Check that a time server has set the clock. Otherwise the dates of recordings are wrong.

    The program timedatectl also detects time programs other than systemd-timesyncd.
    """
    arguments = ("show", "--property=NTPSynchronized", "--value")
    if (root / SYNCHRONISED).exists() or _run(root / "usr/bin/timedatectl", *arguments) == "yes":
        yield Finding.ok("clock", "set by a time server", kind="clock-synchronised")
    else:
        message = "no time server has answered since the start: the dates of recordings are wrong"
        remedy = "Connect the board to a network once, and run sudo timedatectl set-ntp true"
        yield Finding.warning("clock", message, remedy, kind="clock-unsynchronised")


ENOUGH_GB, LEAST_GB = 2.0, 0.2
"""The doctor warns if less than `ENOUGH_GB` gigabytes are free, and reports an error below `LEAST_GB`. A recording with
pictures takes up to a gigabyte an hour. Without free space the system itself fails."""


def check_disk(root: Path) -> Iterator[Finding]:
    """Check the free space on the system's disk."""
    free = shutil.disk_usage(root).free / 1e9
    message, remedy = f"{free:.1f} GB are free", "Delete old recordings; sudo apt clean"
    if free < LEAST_GB:
        yield Finding.error("disk", message, remedy, kind="disk-full")
    elif free < ENOUGH_GB:
        yield Finding.warning("disk", message, remedy, kind="disk-low")
    else:
        yield Finding.ok("disk", message, kind="disk-ok")
