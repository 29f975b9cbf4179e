"""A virtual machine that runs one command on the host's files, and returns the lines of its serial port."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from threading import Timer

from tests.system import needs
from tests.system.gpio.kernel import Kernel

REPORT_PORT = "/dev/ttyS1"
"""The guest's port whose lines the host reads. The command's own output goes to the console's log."""

MACHINE = (
    "-accel",
    "tcg",
    "-cpu",
    "Nehalem",
    "-smp",
    "2",
    "-m",
    "1024",
    "-nodefaults",
    "-display",
    "none",
    "-no-reboot",
)
HOST_FILES = "local,path=/,mount_tag=host,security_model=none,readonly=on,multidevs=remap"
KERNEL_LINE = "console=ttyS0 quiet mitigations=off no_timer_check panic=-1 rdinit=/init --"


@contextmanager
def run_in_guest(kernel: Kernel, command: Sequence[str], console: Path, limit_s: float) -> Iterator[Iterator[str]]:
    """Run a command as root in the machine; yield the lines of `REPORT_PORT` until it ends or its time is over."""
    qemu = [*needs.ENDING_WITH_US, "qemu-system-x86_64", *MACHINE, "-virtfs", HOST_FILES]
    boot = ["-kernel", str(kernel.image), "-initrd", str(kernel.initramfs)]
    line = " ".join([KERNEL_LINE, *command])
    ports = ["-serial", f"file:{console}", "-serial", "stdio"]
    with subprocess.Popen(
        [*qemu, *boot, "-append", line, *ports], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True
    ) as process:
        timer = Timer(limit_s, process.kill)
        timer.start()
        try:
            assert process.stdout
            yield iter(process.stdout)
        finally:
            timer.cancel()
            process.kill()
