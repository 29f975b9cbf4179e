"""The firmware built for a simulated board, with a robot's own wiring."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping
from pathlib import Path

from robotcore.hardware.firmware import toolchain
from robotcore.hardware.firmware.board import BOARDS, shipped_sketch

STRICT = ("-Wall", "-Wextra", "-Werror")
"""Our own sketch gives no warning."""


def build(folder: Path, config: Mapping[str, object] | None = None, sketch: Path | None = None) -> Path:
    """Build a sketch, ours by default, in a folder; return the ELF.

    ``config`` changes names in a copy of its config.h, as a user edits it: ``{"BATTERY_PIN": "A0"}``.
    Needs what ``toolchain.is_here()`` looks for; raises FirmwareError with what the compiler said.
    """
    source = sketch or shipped_sketch()
    copy = folder / source.name
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(source, copy)
    for name, value in (config or {}).items():
        _define(copy / "config.h", name, value)
    image = toolchain.build_with_avr_gcc(copy, BOARDS["uno"], folder / "objects", flags=[] if sketch else STRICT)
    return image.with_suffix(".elf")


def _define(header: Path, name: str, value: object) -> None:
    text, changes = re.subn(rf"(?m)^(#define {name}) .*$", rf"\1 {value}", header.read_text())
    if changes != 1:
        raise LookupError(f"{header}: has {changes} lines `#define {name}`")
    header.write_text(text)
