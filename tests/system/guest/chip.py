"""A chip of simulated lines: read the outputs of a program, and set its inputs.

Source: https://www.kernel.org/doc/html/v6.1/admin-guide/gpio/gpio-sim.html.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from tests.system.guest.bench import wait_until

CONFIG = Path("/sys/kernel/config/gpio-sim/pi")
LINES = Path("/sys/devices/platform")
PERSIST = Path("/sys/module/gpio_sim/parameters/persist_gpio_outputs")
LABEL = "pinctrl-bcm2835"
HEADER = range(28)


class Chip:
    """A chip with every GPIO of the header. At first all are low and free."""

    def __init__(self) -> None:
        bank = CONFIG / "bank"
        bank.mkdir(parents=True)
        bank.joinpath("num_lines").write_text(str(len(HEADER)))
        bank.joinpath("label").write_text(LABEL)
        CONFIG.joinpath("live").write_text("1")
        device, chip = CONFIG.joinpath("dev_name").read_text().strip(), bank.joinpath("chip_name").read_text().strip()
        self._lines = LINES / device / chip
        self.set_persistent(is_persistent=False)

    def remove(self) -> None:
        """Wait until no process has the chip open, and remove it. Otherwise the next chip would get another number."""
        wait_until(_holders, set())
        CONFIG.joinpath("live").write_text("0")
        CONFIG.joinpath("bank").rmdir()
        CONFIG.rmdir()

    def level(self, gpio: int) -> int:
        """Return the level of a line: its holder's output, or its pull."""
        return int(self.file(gpio, "value").read_text())

    def high(self) -> list[int]:
        """Return the GPIOs that are high."""
        return [gpio for gpio in HEADER if self.level(gpio)]

    def pull(self, gpio: int, level: int) -> None:
        """Set the level of an input."""
        self.file(gpio, "pull").write_text("pull-up" if level else "pull-down")

    def file(self, gpio: int, name: str) -> Path:
        """Return the file ``value`` or ``pull`` of a line."""
        return self._lines / f"sim_gpio{gpio}" / name

    def set_persistent(self, *, is_persistent: bool) -> None:
        """Set whether released lines keep their level, as on Raspberry Pi OS."""
        PERSIST.write_text("Y" if is_persistent else "N")


def _holders() -> set[str]:
    """Return the numbers of the processes that have the chip open."""
    holders = set()
    for file in Path("/proc").glob("[0-9]*/fd/*"):
        with suppress(OSError):  # closed meanwhile
            if str(file.readlink()).startswith("/dev/gpiochip"):
                holders.add(file.parts[2])
    return holders
