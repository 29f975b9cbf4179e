"""Simulated GPIO lines that processes share, by a double of lgpio in this folder."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

FOLDER = Path(__file__).parent
ROOT = Path(__file__).parents[4]
SET_PULL_DOWN = 64
"""lgpio's flag for a pull-down."""

END_S = 60.0
"""The time limit for the end of a program."""

Program = subprocess.Popen[str]
Launch = Callable[..., Program]


class Lines:
    """A chip whose lines are all free and low at first."""

    def __init__(self, folder: Path) -> None:
        self._dev = folder
        self._chip = folder / "gpiochip0"
        self._chip.mkdir(parents=True)

    def level(self, gpio: int) -> int:
        """Return the last output of a line: 0, 1, or a duty in percent."""
        line = self._chip / str(gpio)
        return int(line.read_text()) if line.exists() else 0

    def is_pulled_down(self, gpio: int) -> bool:
        """Return whether the last holder of a line has set a pull-down."""
        pull = self._chip / f"{gpio}.pull"
        return pull.exists() and int(pull.read_text()) == SET_PULL_DOWN

    @property
    def environment(self) -> dict[str, str]:
        """Return the environment of a process that uses these lines."""
        return {**os.environ, "PYTHONPATH": f"{FOLDER}{os.pathsep}{ROOT}", "FAKE_DEV": str(self._dev)}


def wait_for_end(program: Program) -> tuple[str, str]:
    """Wait until the program and its guardian have ended; return stdout and stderr."""
    return program.communicate(timeout=END_S)


def wait_for_level(lines: Lines, gpio: int, program: Program, *, is_high: bool) -> None:
    """Wait until a line is high or low. The test's time limit ends the wait otherwise."""
    while bool(lines.level(gpio)) != is_high:
        with suppress(subprocess.TimeoutExpired):
            program.wait(0.01)
            raise AssertionError(program.communicate())
