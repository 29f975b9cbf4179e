"""Which board this is, and whether its programs are 64-bit."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from drivers.raspberrypi.doctor.files import told
from robotcore.hal.finding import Finding

MODEL = "proc/device-tree/model"
BITS = {1: 32, 2: 64}
"""By the fifth byte of an ELF file. Source: elf(5), EI_CLASS."""


def model(root: Path) -> str | None:
    """Return what the board calls itself, such as ``Raspberry Pi 5 Model B Rev 1.0``; None where it does not."""
    try:
        return told(root / MODEL)
    except OSError:
        return None


def is_raspberry_pi(root: Path = Path("/")) -> bool:
    """Return whether this is one, of whatever model."""
    return (model(root) or "").startswith("Raspberry Pi")


def board(root: Path) -> Iterator[Finding]:
    """Look which board this is, and whether this Python is a 64-bit one: only for that libraries come ready built."""
    bits = python_bits(root)
    said = f"{model(root)}, {bits}-bit Python"
    if bits == 64:
        yield Finding.ok("board", said)
    else:
        remedy = "Install the 64-bit Raspberry Pi OS: NumPy and OpenCV are not built for 32 bits"
        yield Finding.warning("board", said, remedy)


def python_bits(root: Path) -> int:
    """Return how wide this program's pointers are, whatever the kernel's are."""
    with (root / "proc/self/exe").open("rb") as program:
        return BITS[program.read(5)[4]]
