"""``robotcore wiring``: where a robot's wires go.

``--json`` prints ``{"robot", "backend", "wires": [{"device", "what", "signal", "where", "pads"}, …], "pads":
[{"number", "name", "kind"}, …], "notes": [{"device", "note"}, …]}``: a wire may go to any of its ``pads``, best to the
first, to none of them where it does not go to the connector; ``kind`` is one of signal, power, ground, reserved.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.output import as_json, write_json, write_line, write_lines, write_table
from robotcore.cli.placed import options_of, placed, placed_robot

if TYPE_CHECKING:
    from robotcore.hal.wiring import Wire, Wiring


@click.command("wiring")
@click.argument("robot", default="rover")
@click.option("--backend", default="raspberrypi", show_default=True, help="The board whose wiring to show.")
@placed
@as_json
def command(robot: str, backend: str, port: str | None, options: tuple[tuple[str, str], ...], *, as_json: bool) -> None:
    """Show where the wires of ROBOT go.

    As its file says: in a table and on the board's connector, if it has one, with what else there is to know.
    """
    wiring = _wiring(robot, backend, options_of(port, options))
    if as_json:
        write_json({"robot": robot, "backend": backend, **_told(wiring)})
        return
    from robotcore.cli.connector import drawing

    columns = ("device", "signal", "goes to", *(["pad"] if wiring.pads else []), "what it is")
    write_table(columns, _rows(wiring))
    write_line()
    if wiring.pads:
        for line in drawing(wiring):
            write_line(line, is_styled=True)
        write_line()
    for note in _notes(wiring):
        write_lines(note)


def _wiring(robot: str, name: str, options: Mapping[str, str]) -> Wiring:
    from robotcore.errors import UsageError
    from robotcore.hal.backend import load_backend

    backend = load_backend(name)
    wiring = backend.wiring(placed_robot(backend, robot, options))
    if wiring is None:
        raise UsageError(f"the backend {name!r} has nothing to wire. Take the real robot's: --backend raspberrypi")
    return wiring


def _rows(wiring: Wiring) -> Iterator[tuple[str, ...]]:
    last = ""
    for wire in wiring.wires:
        is_first, last = wire.device != last, wire.device
        pads = [_pads(wire)] if wiring.pads else []
        yield wire.device if is_first else "", wire.signal, wire.where, *pads, wire.what if is_first else ""


def _pads(wire: Wire) -> str:
    if not wire.pads:
        return "-"
    first, *others = wire.pads
    if len(others) > 1:
        return f"{first}, or another {wire.where}"
    return f"{first} or {others[0]}" if others else str(first)


def _notes(wiring: Wiring) -> Iterator[str]:
    """Yield each note in lines of 100 columns, with the devices to which it belongs."""
    devices: dict[str, list[str]] = {}
    for device, note in wiring.notes:
        devices.setdefault(note, []).append(device)
    for note, names in devices.items():
        yield click.wrap_text(f"- {', '.join(names)}: {' '.join(note.split())}", 100, "", "  ")


def _told(wiring: Wiring) -> dict[str, Any]:
    from dataclasses import asdict

    return {
        "wires": [asdict(wire) for wire in wiring.wires],
        "pads": [{**asdict(pad), "kind": pad.kind.value} for pad in wiring.pads],
        "notes": [{"device": device, "note": note} for device, note in wiring.notes],
    }
