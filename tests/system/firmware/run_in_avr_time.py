"""Run ``robotcore`` with the serial drivers in the AVR's time, because the simulation may be slower than real time.

Use: python -m tests.system.firmware.run_in_avr_time FOLDER ARGUMENT...

FOLDER has the files of the simulated robot.
"""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

from drivers.serial import backend
from robotcore.cli.main import main
from robotcore.hal.wall_clock import ServerClock
from tests.system.firmware.simulated import SimulatedRobot, map_bench

if __name__ == "__main__":
    folder = Path(sys.argv.pop(1))
    simulated = SimulatedRobot(folder, map_bench(folder))
    vars(backend)["MonotonicClock"] = partial(ServerClock, simulated.now)
    main()
