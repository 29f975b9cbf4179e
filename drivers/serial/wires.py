"""Where a robot's devices are plugged in, in words and as wires; no connector of this computer has pads for them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from robotcore.hal.wiring import Wire, Wiring
from robotcore.hardware import Fitting
from robotcore.text import counted


def ports_of(fittings: Iterable[Fitting]) -> tuple[str, ...]:
    """Return the serial ports that devices are on, each once, in the order of the file."""
    wires = (wire for fitting in fittings for wire in fitting.connections)
    return tuple(dict.fromkeys(wire.where for wire in wires if wire.bus == "serial"))


def counted_on(fittings: Sequence[Fitting]) -> str:
    """Return how many devices these are, and on which ports, in words."""
    ports = ports_of(fittings)
    return counted(len(fittings), "device") + (f" on {', '.join(ports)}" if ports else "")


def wiring_of(fittings: Sequence[Fitting]) -> Wiring:
    """Return the wires of these devices: of each its signals, then what feeds it."""
    wires = [wire for fitting in fittings for wire in _wires(fitting)]
    return Wiring((), wires, tuple((fitting.name, note) for fitting in fittings for note in fitting.notes))


def _wires(fitting: Fitting) -> Iterator[Wire]:
    what = f"{fitting.told.kind.replace('_', ' ')}, {fitting.driver.name}"
    for wire in fitting.connections:
        yield Wire(fitting.name, what, wire.signal, str(wire))
    for name in fitting.driver.supply:
        yield Wire(fitting.name, what, "ground" if name == "ground" else "supply", name)
