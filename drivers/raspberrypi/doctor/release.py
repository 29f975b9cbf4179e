"""Which release of the operating system this is."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from drivers.raspberrypi.doctor.files import told
from robotcore.hal.finding import Finding

TESTED = ("bookworm", "trixie")
"""Releases whose lgpio and picamera2 are known to fit."""


def release(root: Path) -> Iterator[Finding]:
    """Look whether the release is one that is known."""
    about = fields(told(root / "etc/os-release"))
    said = about.get("PRETTY_NAME", "a system without a name")
    if about.get("VERSION_CODENAME") in TESTED:
        yield Finding.ok("system", said)
    else:
        remedy = f"Take Raspberry Pi OS {' or '.join(name.capitalize() for name in TESTED)}, the 64-bit one"
        yield Finding.warning("system", f"{said}: nobody has tried it", remedy)


def fields(text: str) -> dict[str, str]:
    """Return the fields of an os-release file, without quotes. Source: os-release(5)."""
    pairs = (line.partition("=") for line in text.splitlines() if "=" in line and not line.startswith("#"))
    return {key.strip(): value.strip().strip("\"'") for key, _, value in pairs}
