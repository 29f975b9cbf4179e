"""``robotcore`` with the serial drivers in the AVR's time: python -m tests.system.firmware.following FOLDER ARGUMENT...

So the simulation may be slower than real time. FOLDER is that of the simulated robot.
"""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

from drivers.serial import backend
from robotcore.cli.main import main
from robotcore.hal.wall_clock import ServerClock
from tests.system.firmware.simulated import SimulatedRobot, joined

if __name__ == "__main__":
    folder = Path(sys.argv.pop(1))
    simulated = SimulatedRobot(folder, joined(folder))
    vars(backend)["MonotonicClock"] = partial(ServerClock, simulated.now)
    main()
