"""A virtual machine that runs one command on the host's files."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from threading import Timer

from tests.system import needs
from tests.system.gpio.kernel import Kernel

REPORT_PORT = "/dev/ttyS1"
"""The guest's serial port whose lines the host reads. The command's standard output is in the log ``console``."""

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
    """Run a command as root in a virtual machine; yield the lines that the command writes to `REPORT_PORT`.

    The lines end when the machine ends, or after ``limit_s`` seconds.
    """
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
