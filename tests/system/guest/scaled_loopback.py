"""The loopback test with longer time limits and fewer trials, because an emulated processor is slow.

python -m tests.system.guest.scaled_loopback doctor|motor_program ARGUMENT...
"""

from __future__ import annotations

import sys

from drivers.raspberrypi.loopback import echoes, encoder_edges, motor_program, outputs, processes, stops, wires
from robotcore.cli.main import main
from tests.system.guest.scaled_limits import scale_limits
from tests.system.speed import scaled

if __name__ == "__main__":
    scale_limits()
    stops.TRIALS, echoes.ECHOES, outputs.TOGGLES = 1, 2, 10
    encoder_edges.DURATION_S, encoder_edges.SETTLE_S = 0.1, scaled(encoder_edges.SETTLE_S)
    wires.SETTLE_S = scaled(wires.SETTLE_S)
    outputs.LATE_S = scaled(outputs.LATE_S)
    processes.START_S, processes.END_S = scaled(processes.START_S), scaled(processes.END_S)
    processes.LoopbackProgram.command = [sys.executable, "-m", "tests.system.guest.scaled_loopback", "motor_program"]
    if sys.argv[1] == "motor_program":
        del sys.argv[1]
        motor_program.main()
    else:
        main()
