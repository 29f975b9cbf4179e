"""Run the program of the loopback test as on a Raspberry Pi 3."""

from __future__ import annotations

from unittest.mock import patch

from drivers.raspberrypi.loopback.motor_program import main
from tests.drivers.raspberrypi.run_as_pi import PI_3

if __name__ == "__main__":
    with patch("gpiozero.pins.local.get_pi_revision", lambda: PI_3):
        main()
