"""Turn a motor on a board, under a guardian: ``python -m tests.drivers.serial.boards.motor_program PORT``."""

from __future__ import annotations

import sys
from select import select

from drivers.serial.boards.waveshare.drivers import WaveshareBattery
from drivers.serial.line import Line
from robotcore.description import load_robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import DeviceContext
from robotcore.safety.guardian.client import Guardian
from tests.doubles.serial.line import PollingProtocol

LEASE_S = 0.3
TURN, STOP = b"go;", b"stop;"


def main() -> None:
    """Turn the motor until a line arrives on standard input."""
    port, clock = sys.argv[1], MonotonicClock()
    protocol = PollingProtocol()
    line = Line(port, protocol, clock)
    line.open("left_motor", 5.0)
    spec = WaveshareBattery(port=port).stop_frame("left_motor", STOP, "!", DeviceContext(load_robot("rover"), clock))
    with Guardian([spec], LEASE_S) as guardian:
        while not select([sys.stdin], [], [], 0.02)[0]:
            guardian.renew_lease()
            protocol.set_word(TURN)
            line.wake()
        guardian.end_lease()
    line.close()
    clock.close()


if __name__ == "__main__":
    main()
