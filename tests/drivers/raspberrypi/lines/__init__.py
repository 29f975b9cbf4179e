"""Lines that processes claim and leave, without a chip: the folder is put before the real lgpio."""

from __future__ import annotations

import os
from pathlib import Path

FOLDER = Path(__file__).parent
ROOT = Path(__file__).parents[4]


class Lines:
    """A chip that has every line, all of them free and low."""

    def __init__(self, folder: Path) -> None:
        self._dev = folder
        self._chip = folder / "gpiochip0"
        self._chip.mkdir(parents=True)

    def level(self, gpio: int) -> int:
        """Return what was put out last: 0, 1, or a duty in percent."""
        line = self._chip / str(gpio)
        return int(line.read_text()) if line.exists() else 0

    @property
    def environment(self) -> dict[str, str]:
        """What a process is to be given that is to work these lines."""
        return {**os.environ, "PYTHONPATH": f"{FOLDER}{os.pathsep}{ROOT}", "FAKE_DEV": str(self._dev)}
