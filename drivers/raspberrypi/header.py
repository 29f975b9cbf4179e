"""The 40-pin header of every board since the B+: its pads, its GPIOs, its serial port, and the wires to it.

Source: https://www.raspberrypi.com/documentation/computers/raspberry-pi.html#gpio, and `pinout`, which comes with
gpiozero.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import Annotated, NoReturn

from pydantic import AfterValidator, Field

from robotcore.hal.wiring import Pad, PadKind, Wire, Wiring
from robotcore.hardware import Connection, DeviceBinding

_LAYOUT = """
    3.3V  5V
    2     5V
    3     GND
    4     14
    GND   15
    17    18
    27    GND
    22    23
    3.3V  24
    10    GND
    9     25
    11    8
    GND   7
    ID_SD ID_SC
    5     GND
    6     12
    13    GND
    19    16
    26    20
    GND   21
"""
"""Pads 1 and 2 in the first row, beside the corner of the board; numbers are GPIOs."""

_NAMED = {
    "3.3V": ("3.3 V", PadKind.POWER),
    "5V": ("5 V", PadKind.POWER),
    "GND": ("ground", PadKind.GROUND),
    "ID_SD": ("ID_SD", PadKind.RESERVED),
    "ID_SC": ("ID_SC", PadKind.RESERVED),
}
"""ID_SD and ID_SC are GPIO 0 and 1: the board asks there, when it starts, which HAT it carries."""


def _pad(number: int, what: str) -> Pad:
    name, kind = _NAMED.get(what, (f"GPIO {what}", PadKind.SIGNAL))
    return Pad(number, name, kind)


HEADER = tuple(_pad(number, what) for number, what in enumerate(_LAYOUT.split(), start=1))
"""Its pads by their numbers, from 1."""

GPIO_NOTES = {
    (0, 1): "GPIO 0 and 1 are where the Pi asks at its start which HAT it carries. Take others, unless all are taken.",
    (14, 15): (
        "GPIO 14 and 15 are the serial console's where it is switched on, and 14 sends while the Pi starts. Switch it "
        "off (sudo raspi-config, Interface Options, Serial Port), or take others."
    ),
}
"""What to know of GPIOs that the Pi uses for something else, whatever is connected to them."""

_RENAMED = {"GPIO 0": "ID_SD", "GPIO 1": "ID_SC"}


def wiring_of(fittings: Iterable[DeviceBinding]) -> Wiring:
    """Return the wires of these devices on the header: of each its signals, then what feeds it."""
    fittings = tuple(fittings)
    wires: list[Wire] = []
    for fitting in fittings:
        signals = list(_signal_wires(fitting))
        wires += signals
        wires += _supply_wires(fitting, signals, taken=Counter(wire.pads[0] for wire in wires if wire.pads))
    notes = ((fitting.name, note) for fitting in fittings for note in (*fitting.notes, *_gpio_notes(fitting)))
    return Wiring(HEADER, wires, tuple(notes))


def count_wires(fittings: Sequence[DeviceBinding]) -> str:
    """Return how many devices and wires these are, in words."""
    return f"{len(fittings)} devices, {sum(len(fitting.connections) for fitting in fittings)} wires"


def pads_of(name: str) -> tuple[int, ...]:
    """Return the numbers of the pads of that name."""
    return tuple(pad.number for pad in HEADER if pad.name == name)


def _signal_wires(fitting: DeviceBinding) -> Iterator[Wire]:
    for connection in fitting.connections:
        for wire in (connection, *lines_of(connection)):
            place = str(wire)
            yield Wire(fitting.name, _label(fitting), wire.signal, place, pads_of(_RENAMED.get(place, place)))


def _gpio_notes(fitting: DeviceBinding) -> Iterator[str]:
    places = {wire.where for wire in _signal_wires(fitting)}
    if any(map(is_header_port, fitting.connections)):
        yield PORT_NOTE
    yield from (note for gpios, note in GPIO_NOTES.items() if places & {f"GPIO {gpio}" for gpio in gpios})


def _supply_wires(fitting: DeviceBinding, signals: Iterable[Wire], taken: Counter[int]) -> Iterator[Wire]:
    """Yield what feeds a device, on the pads that fewest wires go to and that are nearest to its signals."""
    rows = [_row(pad) for wire in signals for pad in wire.pads] or [1]
    middle = sum(rows) / len(rows)
    for name in fitting.driver.supply:
        pads = sorted(pads_of(name), key=lambda pad: (taken[pad], abs(_row(pad) - middle)))
        yield Wire(fitting.name, _label(fitting), "ground" if name == "ground" else "supply", name, tuple(pads))


def _row(pad: int) -> int:
    return (pad + 1) // 2


def _label(fitting: DeviceBinding) -> str:
    return f"{fitting.description.kind.replace('_', ' ')}, {fitting.driver.name}"


def _on_header(number: int) -> int:
    if number not in GPIOS:
        _refuse(number)
    return number


def _refuse(number: int | str) -> NoReturn:
    pad = next((f"; pad {number} of the header is {pad.name}" for pad in HEADER if pad.number == number), "")
    raise ValueError(f"there is no GPIO {number} on the header{pad}; take 0 to 27, the numbers of the chip (BCM)")


GPIOS = range(28)
"""Those on the header, the same on every board since the B+. Source: https://pinout.xyz."""

PULLED_UP = range(9)
"""Inputs with a pull-up, until a program drives them: the others have a pull-down.
Source: BCM2835 ARM Peripherals, 6.2, the column Pull; the same on a Pi 5."""

HELD_UP = (2, 3)
"""Of these, those with a resistor of 1.8 kΩ to 3.3 V on the board besides, for I²C."""

Gpio = Annotated[
    int, AfterValidator(_on_header), Field(description="the number of a GPIO on the header (BCM), 0 to 27")
]
"""A pin in a robot's file."""


def gpio(signal: str, number: int, *, is_shared: bool = False, instead: str = "") -> Connection:
    """Return the wire from a device's ``signal`` to a GPIO."""
    return Connection(signal, "GPIO", str(number), is_shared, instead)


def on_header(wire: Connection) -> tuple[Connection, ...]:
    """Return which pins a wire takes that is a serial port's.

    Raises ValueError, the fault, a semicolon and the remedy, for a wire to a GPIO that is none of the header's.
    """
    if wire.bus == "GPIO" and wire.where not in map(str, GPIOS):
        _refuse(int(wire.where) if wire.where.isdecimal() else wire.where)
    return lines_of(wire)


HEADER_PORTS = ("/dev/serial0", "/dev/ttyAMA0", "/dev/ttyS0")
"""``serial0`` up to a Pi 4, where it is one of the other two; ``ttyAMA0`` on a Pi 5."""

_PORT_LINES = (("sends", "14"), ("hears", "15"))
"""TXD and RXD."""


PORT_NOTE = (
    "The port sends on GPIO 14, to the board's RX, and hears on GPIO 15, from its TX, both at 3.3 V: a TX of 5 V, such "
    "as an Arduino Uno's, needs a divider, 1 kΩ to GPIO 15 and 2 kΩ from there to ground, or the board goes on USB. On "
    "a Pi 5 the port is /dev/ttyAMA0."
)
"""What whoever connects something to it must know."""


def is_header_port(wire: Connection) -> bool:
    """Return whether a device's wire is the port on the header, by the name that it has there."""
    return wire.bus == "serial" and wire.where in HEADER_PORTS


def lines_of(wire: Connection) -> tuple[Connection, ...]:
    """Return the pins that a wire takes as a port; none where it is no port on the header."""
    if not is_header_port(wire):
        return ()
    return tuple(
        Connection(signal, "GPIO", gpio, wire.is_shared, protocol=wire.protocol) for signal, gpio in _PORT_LINES
    )
