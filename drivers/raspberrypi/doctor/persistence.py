"""Whether a pin keeps its level after the program that set it has died.

Sources: https://github.com/raspberrypi/linux/pull/6117 and pull/6150 (the parameter, in both pin controllers, on by
default on a Pi's kernel), and the whitepaper on GPIO from Linux user space (how to switch it off).
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from drivers.raspberrypi.doctor.files import told
from drivers.raspberrypi.lg import header_driver
from robotcore.hal.finding import Finding

WHAT = "killed runs"
PARAMETERS = "sys/module/{module}/parameters/persist_gpio_outputs"
ANY = "pinctrl_*"
REMEDY = (
    "Add the line dtparam=strict_gpiod to /boot/firmware/config.txt and restart; "
    "and let a resistor of 10 kΩ pull the motor board's enable or standby pin down"
)


def persistence(root: Path) -> Iterator[Finding]:
    """Look whether the kernel lets go of outputs: a motor that was on when its program was killed would stay on.

    One kernel has the drivers of several boards, and strict_gpiod sets that of its own: only the header's counts.
    """
    module = (header_driver(root) or ANY).replace("-", "_")
    settings = {file.parts[-3]: told(file) for file in sorted(root.glob(PARAMETERS.format(module=module)))}
    if keeping := [module for module, value in settings.items() if value.upper() in ("Y", "1")]:
        said = f"outputs keep their level after a program was killed ({', '.join(keeping)}.persist_gpio_outputs=Y)"
        yield Finding.warning(WHAT, f"{said}: a motor that was on stays on, but for the guardian", REMEDY)
    elif settings:
        yield Finding.ok(WHAT, "outputs are let go of when their program dies")
    else:
        said = "this kernel has no parameter persist_gpio_outputs: it may be too old"
        yield Finding.unchecked(WHAT, said, f"sudo apt full-upgrade. {REMEDY}")
