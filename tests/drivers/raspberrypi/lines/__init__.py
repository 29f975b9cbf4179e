"""Lines that processes claim and leave, without a chip: the folder is put before the real lgpio."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

FOLDER = Path(__file__).parent
ROOT = Path(__file__).parents[4]
SET_PULL_DOWN = 64
"""lgpio's."""

END_S = 60.0
"""A program that was ended is gone by then."""

Program = subprocess.Popen[str]
Launch = Callable[..., Program]


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

    def is_pulled_down(self, gpio: int) -> bool:
        """Return whether it is low where nobody drives it, as far as the last holder has it."""
        pull = self._chip / f"{gpio}.pull"
        return pull.exists() and int(pull.read_text()) == SET_PULL_DOWN

    @property
    def environment(self) -> dict[str, str]:
        """What a process is to be given that is to work these lines."""
        return {**os.environ, "PYTHONPATH": f"{FOLDER}{os.pathsep}{ROOT}", "FAKE_DEV": str(self._dev)}
