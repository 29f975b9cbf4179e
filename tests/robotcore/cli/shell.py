"""A shell that runs one job in its terminal: ``python -m tests.robotcore.cli.shell foreground|background COMMAND…``.

Prints ``stopped`` if the job is stopped. Each byte from descriptor `CONTROL` then continues the job in the
foreground. At the end of the job, prints ``exited`` and the status.
"""

from __future__ import annotations

import fcntl
import os
import signal
import subprocess
import sys
import termios

TERMINAL, CONTROL = 0, int(os.environ.get("CONTROL", "3"))


def main(place: str, *command: str) -> None:
    fcntl.ioctl(TERMINAL, termios.TIOCSCTTY, 0)
    signal.signal(signal.SIGTTOU, signal.SIG_IGN)

    def begin() -> None:
        os.setpgid(0, 0)
        if place == "foreground":
            os.tcsetpgrp(TERMINAL, os.getpid())
        signal.signal(signal.SIGTTOU, signal.SIG_DFL)

    job = subprocess.Popen(command, preexec_fn=begin)  # noqa: PLW1509  there are no threads here
    while True:
        _, status = os.waitpid(job.pid, os.WUNTRACED)
        os.tcsetpgrp(TERMINAL, os.getpgrp())
        if not os.WIFSTOPPED(status):
            break
        write_line("stopped")
        os.read(CONTROL, 1)
        os.tcsetpgrp(TERMINAL, job.pid)
        os.kill(job.pid, signal.SIGCONT)
    write_line(f"exited {os.waitstatus_to_exitcode(status)}")


def write_line(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
