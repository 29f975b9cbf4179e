"""Run the command line as on a Raspberry Pi 3: ``python -m tests.drivers.raspberrypi.run_as_pi run APP …``."""

from __future__ import annotations

from unittest.mock import patch

from robotcore.cli.main import main

PI_3 = 0xA02082

if __name__ == "__main__":
    with patch("gpiozero.pins.local.get_pi_revision", lambda: PI_3):
        main()
