"""An ultrasonic module on the bench: a program that answers the trigger."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

from tests.system.guest.chip import Chip

TRIGGER, ECHO = 16, 26
DELAY_US = 500
METRES_A_MICROSECOND = 343e-6 / 2


@contextmanager
def answering(chip: Chip, distance: float) -> Iterator[None]:
    """Let the module hear an echo from that far."""
    lines = [chip.file(TRIGGER, "value"), chip.file(ECHO, "pull")]
    times = [DELAY_US, round(distance / METRES_A_MICROSECOND)]
    command = [os.environ["ECHO_HELPER"], *map(str, (*lines, *times))]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout
            assert process.stdout.readline() == "ready\n"
            yield
        finally:
            process.kill()
