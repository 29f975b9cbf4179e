"""The 40-pin header of every Raspberry Pi since the B+: pads, GPIOs, the serial port, and the wires of devices.

Source: https://www.raspberrypi.com/documentation/computers/raspberry-pi.html#gpio, and gpiozero's `pinout`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Annotated

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
"""The pads of the header, two in each row. A number is a GPIO. Pads 1 and 2, the first row, are at the corner of the
board."""

_NAMED = {
    "3.3V": ("3.3 V", PadKind.POWER),
    "5V": ("5 V", PadKind.POWER),
    "GND": ("ground", PadKind.GROUND),
    "ID_SD": ("ID_SD", PadKind.RESERVED),
    "ID_SC": ("ID_SC", PadKind.RESERVED),
}
"""The names and kinds of the pads that are not plain GPIOs. ID_SD and ID_SC are GPIO 0 and 1, by which the starting Pi
identifies a HAT."""


HEADER = tuple(
    Pad(number, *_NAMED.get(what, (f"GPIO {what}", PadKind.SIGNAL)))
    for number, what in enumerate(_LAYOUT.split(), start=1)
)
"""The pads in the order of their numbers, from 1."""

GPIO_NOTES = {
    (0, 1): "The Pi uses GPIO 0 and 1 at its start to identify a HAT. Use them only if all other GPIOs are in use.",
    (14, 15): (
        "The serial console uses GPIO 14 and 15 if it is switched on, and GPIO 14 sends while the Pi starts. Switch "
        "the console off (sudo raspi-config, Interface Options, Serial Port), or use other GPIOs."
    ),
}
"""The notes that `robotcore wiring` prints for a device on GPIOs that the Pi itself uses too."""

_RENAMED = {"GPIO 0": "ID_SD", "GPIO 1": "ID_SC"}


def build_wiring(bindings: Iterable[DeviceBinding]) -> Wiring:
    """Return the wires of these devices on the header and the notes. A device has signal wires, then supply wires.

    A board on the header's serial port has one ground wire, in the list of its first device.
    """
    bindings = tuple(bindings)
    wires: list[Wire] = []
    grounded: set[str] = set()
    for binding in bindings:
        signals = list(_signal_wires(binding))
        wires += signals
        ports = {wire.where for wire in binding.driver.connections() if is_header_port(wire)}
        needs_ground = ports - grounded and "ground" not in binding.driver.supply
        grounded |= ports
        supply = (*binding.driver.supply, *(["ground"] if needs_ground else []))
        taken = Counter(wire.pads[0] for wire in wires if wire.pads)
        wires += _supply_wires(binding, supply, signals, taken)
    notes = ((binding.name, note) for binding in bindings for note in (*binding.notes, *_gpio_notes(binding)))
    return Wiring(HEADER, wires, tuple(notes))


def find_pads(name: str) -> tuple[int, ...]:
    """Return the numbers of the pads with this name, such as ``ground``."""
    return tuple(pad.number for pad in HEADER if pad.name == name)


def _signal_wires(binding: DeviceBinding) -> Iterator[Wire]:
    for connection in binding.driver.connections():
        for wire in (connection, *resolve_pins(connection)):
            place = str(wire)
            yield Wire(binding.name, binding.label, wire.signal, place, find_pads(_RENAMED.get(place, place)))


def _gpio_notes(binding: DeviceBinding) -> Iterator[str]:
    places = {wire.where for wire in _signal_wires(binding)}
    if any(map(is_header_port, binding.driver.connections())):
        yield PORT_NOTE
    yield from (note for gpios, note in GPIO_NOTES.items() if places & {f"GPIO {gpio}" for gpio in gpios})


def _supply_wires(
    binding: DeviceBinding, supply: Iterable[str], signals: Iterable[Wire], taken: Counter[int]
) -> Iterator[Wire]:
    # A wire goes to the pad with the fewest wires. Of several such pads, the nearest to the signals is used.
    rows = [_row(pad) for wire in signals for pad in wire.pads] or [1]
    middle = sum(rows) / len(rows)
    for name in supply:
        pads = sorted(find_pads(name), key=lambda pad: (taken[pad], abs(_row(pad) - middle)))
        yield Wire(binding.name, binding.label, "ground" if name == "ground" else "supply", name, tuple(pads))


def _row(pad: int) -> int:
    return (pad + 1) // 2


GPIOS = range(28)
"""The GPIOs on the header of every board since the B+. Source: https://pinout.xyz."""

PULLED_UP = range(9)
"""The GPIOs that have a pull-up from power-on until a program sets them. All others have a pull-down.

Source: BCM2835 ARM Peripherals, 6.2, the column Pull; the same on a Pi 5."""

HEADER_BUS = 1
"""The number of the I2C bus on GPIO 2 and 3 of every board since 2012."""

HELD_UP = (2, 3)
"""The GPIOs of the I2C bus, which have a resistor of 1.8 kΩ to 3.3 V on the board."""


def require_gpio(number: int) -> int:
    """Return a number; raises ValueError if it is not that of a GPIO on the header."""
    if number not in GPIOS:
        pad = next((f"; pad {number} of the header is {pad.name}" for pad in HEADER if pad.number == number), "")
        raise ValueError(f"there is no GPIO {number} on the header{pad}; use 0 to 27, the numbers of the chip (BCM)")
    return number


Gpio = Annotated[
    int, AfterValidator(require_gpio), Field(description="the number of a GPIO on the header (BCM), 0 to 27")
]
"""The type of a GPIO in a robot's file."""


def gpio(signal: str, number: int, *, is_shared: bool = False, remedy: str = "") -> Connection:
    """Return the connection of a device's ``signal``, such as ``trigger``, to a GPIO.

    is_shared: whether several devices may use the GPIO.
    remedy: the remedy in the error message if two devices use the GPIO; by default a general one.

    >>> str(gpio("trigger", 23))
    'GPIO 23'
    """
    return Connection(signal, "GPIO", str(number), is_shared, remedy)


HEADER_PORTS = ("/dev/serial0", "/dev/ttyAMA0", "/dev/ttyS0")
"""The names of the header's serial port. Up to a Pi 4 its name is ``serial0``, a link to ``ttyAMA0`` or ``ttyS0``. On a
Pi 5 its name is ``ttyAMA0``."""

PORT_NOTE = (
    "The port sends on GPIO 14, to the board's RX, and receives on GPIO 15, from its TX, both at 3.3 V. A TX of 5 V, "
    "such as an Arduino Uno's, needs a divider: 1 kΩ to GPIO 15, and 2 kΩ from there to ground. Or connect the board "
    "by USB. On a Pi 5 the port is /dev/ttyAMA0."
)
"""The note that `robotcore wiring` prints for a device on the header's serial port."""


def is_header_port(wire: Connection) -> bool:
    """Return whether a wire goes to the header's serial port, by the port's name in the robot's file."""
    return wire.bus == "serial" and wire.where in HEADER_PORTS


def resolve_pins(wire: Connection) -> tuple[Connection, ...]:
    """Return the connections to GPIO 14 and 15 for a wire to the header's serial port; none for any other wire.

    Raises ValueError if the wire goes to a GPIO that is not on the header.
    """
    if wire.bus == "GPIO":
        require_gpio(int(wire.where))
    if not is_header_port(wire):
        return ()
    lines = (("sends", "14"), ("receives", "15"))  # TXD and RXD
    return tuple(replace(wire, signal=signal, bus="GPIO", where=gpio) for signal, gpio in lines)
