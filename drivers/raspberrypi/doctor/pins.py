"""Whether the pins that a robot's devices are on are free."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

from robotcore.hal.finding import Finding
from robotcore.hardware import Connection, Fitting

WHAT = "pins"
IN_USE = 1
"""Of a line's flags: somebody has it, a program or the kernel. Source: lgpio's manual, gpio_get_line_info."""

Users = Callable[[Collection[int]], Mapping[int, str]]
"""Returns of those GPIOs that are not free who has them, in words."""


def users(gpios: Collection[int]) -> dict[int, str]:
    """Return of those GPIOs that are not free who has them, by the kernel's word; none of them is touched."""
    from drivers.raspberrypi.holders import held_by
    from drivers.raspberrypi.lg import chip_number, load

    lgpio = load()
    chip = lgpio.gpiochip_open(chip_number())
    try:
        return {gpio: held_by(gpio) for gpio in gpios if lgpio.gpio_get_line_info(chip, gpio)[2] & IN_USE}
    finally:
        lgpio.gpiochip_close(chip)


def pins(fittings: Iterable[Fitting], users: Users = users) -> Iterator[Finding]:
    """Look whether every GPIO of these devices is free; those of a bus are the kernel's."""
    owners = {int(wire.where): fitting.name for fitting in fittings for wire in _lines(fitting)}
    held = users(sorted(owners)) if owners else {}
    for gpio, holder in held.items():
        said = f"GPIO {gpio} ({owners[gpio]}) is held by {holder}"
        yield Finding.error(WHAT, said, "End that program, or connect the device elsewhere")
    if owners and not held:
        yield Finding.ok(WHAT, f"free: GPIO {', '.join(map(str, sorted(owners)))}")


def _lines(fitting: Fitting) -> Iterator[Connection]:
    wires = fitting.connections
    if not any(wire.bus == "I2C" for wire in wires):
        yield from (wire for wire in wires if wire.bus == "GPIO")
