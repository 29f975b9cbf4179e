"""Run the command line with the loopback test as on a Raspberry Pi 3, on the double of lgpio."""

from __future__ import annotations

import sys
from unittest.mock import patch

from drivers.raspberrypi.loopback.processes import LoopbackProgram
from robotcore.cli.main import main
from tests.drivers.raspberrypi.run_as_pi import PI_3

if __name__ == "__main__":
    LoopbackProgram.command = [sys.executable, "-m", "tests.drivers.raspberrypi.loopback.motor_program_as_pi"]
    with patch("gpiozero.pins.local.get_pi_revision", lambda: PI_3):
        main()
