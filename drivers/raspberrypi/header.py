"""The 40-pin header: what is on which of its pads, on every board since the B+.

Source: https://www.raspberrypi.com/documentation/computers/raspberry-pi.html#gpio, and `pinout`, which comes with
gpiozero.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from drivers.raspberrypi.uart import NOTE, is_header_port, lines_of
from robotcore.hal.wiring import Pad, PadKind, Wire, Wiring
from robotcore.hardware import Fitting

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

OTHERS_TOO = {
    (0, 1): "GPIO 0 and 1 are where the Pi asks at its start which HAT it carries. Take others, unless all are taken.",
    (14, 15): (
        "GPIO 14 and 15 are the serial console's where it is switched on, and 14 sends while the Pi starts. Switch it "
        "off (sudo raspi-config, Interface Options, Serial Port), or take others."
    ),
}
"""What to know of GPIOs that the Pi uses for something else, whatever is connected to them."""

_RENAMED = {"GPIO 0": "ID_SD", "GPIO 1": "ID_SC"}


def wiring_of(fittings: Iterable[Fitting]) -> Wiring:
    """Return the wires of these devices on the header: of each its signals, then what feeds it."""
    fittings = tuple(fittings)
    wires: list[Wire] = []
    for fitting in fittings:
        signals = list(_signals(fitting))
        wires += signals
        wires += _supply(fitting, signals, taken=Counter(wire.pads[0] for wire in wires if wire.pads))
    notes = ((fitting.name, note) for fitting in fittings for note in (*fitting.notes, *_of_gpios(fitting)))
    return Wiring(HEADER, wires, tuple(notes))


def counted(fittings: Sequence[Fitting]) -> str:
    """Return how many devices and wires these are, in words."""
    return f"{len(fittings)} devices, {sum(len(fitting.connections) for fitting in fittings)} wires"


def pads_of(name: str) -> tuple[int, ...]:
    """Return the numbers of the pads of that name."""
    return tuple(pad.number for pad in HEADER if pad.name == name)


def _signals(fitting: Fitting) -> Iterator[Wire]:
    for connection in fitting.connections:
        for wire in (connection, *lines_of(connection)):
            place = str(wire)
            yield Wire(fitting.name, _what(fitting), wire.signal, place, pads_of(_RENAMED.get(place, place)))


def _of_gpios(fitting: Fitting) -> Iterator[str]:
    places = {wire.where for wire in _signals(fitting)}
    if any(map(is_header_port, fitting.connections)):
        yield NOTE
    yield from (note for gpios, note in OTHERS_TOO.items() if places & {f"GPIO {gpio}" for gpio in gpios})


def _supply(fitting: Fitting, signals: Iterable[Wire], taken: Counter[int]) -> Iterator[Wire]:
    """Yield what feeds a device, on the pads that fewest wires go to and that are nearest to its signals."""
    rows = [_row(pad) for wire in signals for pad in wire.pads] or [1]
    middle = sum(rows) / len(rows)
    for name in fitting.driver.supply:
        pads = sorted(pads_of(name), key=lambda pad: (taken[pad], abs(_row(pad) - middle)))
        yield Wire(fitting.name, _what(fitting), "ground" if name == "ground" else "supply", name, tuple(pads))


def _row(pad: int) -> int:
    return (pad + 1) // 2


def _what(fitting: Fitting) -> str:
    return f"{fitting.told.kind.replace('_', ' ')}, {fitting.driver.name}"
