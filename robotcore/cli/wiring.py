"""``robotcore wiring`` shows the wires of a robot, in a table and in a drawing of the board's connector."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import groupby
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.options import backend_option, load_connected_robot, merge_options, port_option
from robotcore.cli.output import as_json, write_json, write_line, write_lines, write_table
from robotcore.text import escape, pluralize

if TYPE_CHECKING:
    from robotcore.hal.wiring import Pad, Wire, Wiring


USES_WIDTH, NAME_WIDTH = 32, 7
"""The widths of the columns for a pad's uses and for its name, in characters. A row then has 95 characters."""

USED, FREE = "●", "○"
STYLES = {"signal": "green", "ground": "blue", "reserved": "magenta", "3.3 V": "yellow", "5 V": "red"}


def draw_connector(wiring: Wiring) -> Iterator[str]:
    """Yield the lines of a drawing of the board's connector. A line has at most 100 characters.

    The drawing has two columns of pads, like the board. A filled dot marks a pad with a wire.
    """
    edge = " " * (USES_WIDTH + NAME_WIDTH + 3)
    yield f"{edge}┌─────────┐"
    for left, right in zip(wiring.pads[::2], wiring.pads[1::2], strict=True):
        numbers = f"│{left.number:>3} │{right.number:>3} │"
        yield f"{_left(left, _format_uses(wiring, left))}{numbers}{_right(right, _format_uses(wiring, right))}"
    yield f"{edge}└─────────┘"
    yield f"{USED} used  {FREE} free    Pad 1 is at the corner of the board; the USB ports are at the other end."


def _format_uses(wiring: Wiring, pad: Pad) -> str:
    """Return the devices and signals on a pad, such as ``left_motor + right_motor standby``."""
    here = [wire for wire in wiring.wires if wire.pads[:1] == (pad.number,)]
    by_signal = groupby(sorted(here, key=attrgetter("signal")), key=attrgetter("signal"))
    devices = {signal: [wire.device for wire in wires] for signal, wires in by_signal}
    text = ", ".join(f"{' + '.join(names)} {signal}" for signal, names in devices.items())
    if len(text) > USES_WIDTH:
        counts = {signal: pluralize(len(names), "device") for signal, names in devices.items() if len(names) > 1}
        text = ", ".join(f"{counts.get(signal, names[0])} {signal}" for signal, names in devices.items())
    text = escape(text)
    return text if len(text) <= USES_WIDTH else f"{text[: USES_WIDTH - 1]}…"


def _left(pad: Pad, uses: str) -> str:
    return f"{_bold(f'{uses:>{USES_WIDTH}}')} {_colour(pad, f'{pad.name:>{NAME_WIDTH}} {_dot(uses)}')}"


def _right(pad: Pad, uses: str) -> str:
    name = f"{pad.name:<{NAME_WIDTH}} " if uses else pad.name
    return f"{_colour(pad, f'{_dot(uses)} {name}')}{_bold(uses)}"


def _dot(uses: str) -> str:
    return USED if uses else FREE


def _colour(pad: Pad, text: str) -> str:
    return click.style(text, STYLES.get(pad.name, STYLES.get(pad.kind.value)), bold=USED in text)


def _bold(text: str) -> str:
    return click.style(text, bold=True) if text.strip() else text


@click.command("wiring")
@click.argument("robot", required=False)
@click.option("--backend", default="raspberrypi", show_default=True, help="The backend of the board.")
@port_option
@backend_option
@as_json
def command(
    robot: str | None, backend: str, port: str | None, options: tuple[tuple[str, str], ...], *, as_json: bool
) -> None:
    """Show how to wire ROBOT.

    Without ROBOT, it is the robot that the pyproject.toml in this folder names, or else the rover.

    Prints a table of the wires, a drawing of the board's connector if it has one, and the notes of the drivers.
    """
    robot = robot or _find_robot()
    wiring = _load_wiring(robot, backend, merge_options(options, port=port))
    if as_json:
        write_json(_build_answer(robot, backend, wiring))
        return

    write_line(f"{robot} on {backend}")
    write_line()
    columns = ("device", "signal", "goes to", *(["pad"] if wiring.pads else []), "description")
    write_table(columns, _rows(wiring))
    write_line()
    if wiring.pads:
        for line in draw_connector(wiring):
            write_line(line, is_styled=True)
        write_line()
    for note in _format_notes(wiring):
        write_lines(note)


def _find_robot() -> str:
    from pathlib import Path

    from robotcore.deploy.project import read_tables

    table = read_tables(Path.cwd()).robotcore
    return (table and table.robot) or "rover"


def _load_wiring(robot: str, name: str, options: Mapping[str, str]) -> Wiring:
    from robotcore.errors import UsageError
    from robotcore.hal.backend import load_backend

    backend = load_backend(name)
    wiring = backend.wiring(load_connected_robot(backend, robot, options))
    if wiring is None:
        raise UsageError(
            f"the backend {name!r} has no wires. Name a real robot's backend, such as --backend raspberrypi",
            kind="no-wiring",
            backend=name,
        )
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


def _format_notes(wiring: Wiring) -> Iterator[str]:
    """Yield each note once, after the names of its devices, wrapped to 100 characters."""
    devices: dict[str, list[str]] = {}
    for device, note in wiring.notes:
        devices.setdefault(note, []).append(device)
    for note, names in devices.items():
        yield click.wrap_text(f"- {', '.join(names)}: {' '.join(note.split())}", 100, "", "  ")


def _build_answer(robot: str, backend: str, wiring: Wiring) -> dict[str, Any]:
    """Return the JSON answer of ``robotcore wiring``.

    The JSON keys:

    robot: text; the name of the robot, or its file.
    backend: text; the name of the board's backend.
    wires: list of objects; the wires.
    wires[].*: robotcore.hal.wiring.Wire
    pads: list of objects; the pads of the board's connector. Empty if it has none.
    pads[].*: robotcore.hal.wiring.Pad
    notes: list of objects; the notes of the drivers.
    notes[].device: text; the name of a device.
    notes[].note: text; a note about its wires.
    """
    from dataclasses import asdict

    return {
        "robot": robot,
        "backend": backend,
        "wires": [asdict(wire) for wire in wiring.wires],
        "pads": [{**asdict(pad), "kind": pad.kind.value} for pad in wiring.pads],
        "notes": [{"device": device, "note": note} for device, note in wiring.notes],
    }
