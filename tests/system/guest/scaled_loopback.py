"""The loopback test with longer time limits: python -m tests.system.guest.scaled_loopback doctor|child ARGUMENT..."""

from __future__ import annotations

import sys

from drivers.raspberrypi.loopback import child, processes
from robotcore.cli.main import main
from tests.system.guest.scaled_limits import scale_limits
from tests.system.speed import scaled

if __name__ == "__main__":
    scale_limits()
    processes.START_S, processes.END_S = scaled(processes.START_S), scaled(processes.END_S)
    processes.LoopbackProgram.command = [sys.executable, "-m", "tests.system.guest.scaled_loopback", "child"]
    if sys.argv[1] == "child":
        del sys.argv[1]
        child.main()
    else:
        main()
