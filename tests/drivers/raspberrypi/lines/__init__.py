"""Simulated GPIO lines that processes share, by a double of lgpio in this folder."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

FOLDER = Path(__file__).parent
ROOT = Path(__file__).parents[4]
SET_PULL_DOWN = 64
"""lgpio's flag for a pull-down."""

END_S = 60.0
"""The time limit for the end of a program."""


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

    def fix_level(self, gpio: int, level: int) -> None:
        """Connect the second end of a wire to a supply pad, so that it always has this level."""
        self._chip.joinpath(f"{gpio}.fixed").write_text(str(level))

    @property
    def environment(self) -> dict[str, str]:
        """Return the environment of a process that uses these lines."""
        return {**os.environ, "PYTHONPATH": f"{FOLDER}{os.pathsep}{ROOT}", "FAKE_DEV": str(self._dev)}


HOLDING = """
import lgpio, sys
chip = lgpio.gpiochip_open(0)
for gpio in map(int, sys.argv[1:]):
    lgpio.gpio_claim_output(chip, gpio, 1)
print("holds", flush=True)
sys.stdin.read()
"""


@contextmanager
def hold_lines(lines: Lines, *gpios: int) -> Iterator[subprocess.Popen[bytes]]:
    """Run a program that holds these lines high, and kill the program at the end."""
    command, pipe = [sys.executable, "-c", HOLDING, *map(str, gpios)], subprocess.PIPE
    with subprocess.Popen(command, env=lines.environment, stdin=pipe, stdout=pipe) as program:
        assert program.stdout
        assert program.stdout.readline() == b"holds\n"
        yield program
        program.kill()
