"""Tools on the PATH that record the arguments of their calls."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


class Tools:
    """A folder of fake tools, which is the whole PATH."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self._folder, self._log = folder / "bin", folder / "calls"
        self._folder.mkdir()
        self._log.touch()
        monkeypatch.setenv("PATH", str(self._folder))

    def put(self, name: str, script: str = "") -> None:
        """Add a tool that records its call and then runs a script of /bin/sh. The arguments are in $*."""
        tool = self._folder / name
        tool.write_text(f'#!/bin/sh\nPATH={os.defpath}\necho "{name} $*" >> "{self._log}"\n{script}\n')
        tool.chmod(0o755)

    @property
    def calls(self) -> list[str]:
        return self._log.read_text().splitlines()


_LIST = "ID          Installed Latest Name\\narduino:avr 1.8.6     1.8.6  Arduino AVR Boards\\n"
LISTS_CORE = f'case "$*" in "core list") printf "{_LIST}";; '
LISTS_NONE = 'case "$*" in "core list") echo "No platforms installed.";; '
COMPILES = 'compile*) touch "$5/$(basename "$6").ino.hex"; echo "Sketch uses 4 bytes.";; esac'
