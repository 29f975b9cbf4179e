"""A connector drawn in the terminal: two columns of pads, as they lie on the board, and what goes to each."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from typing import TYPE_CHECKING

import click

from robotcore.text import escape

if TYPE_CHECKING:
    from robotcore.hal.wiring import Pad, Wire, Wiring

USES, NAME = 32, 7
"""How wide what goes to a pad, and what the pad carries, may be: a row has 95 columns."""

USED, FREE = "●", "○"
STYLES = {"signal": "green", "ground": "blue", "reserved": "magenta", "3.3 V": "yellow", "5 V": "red"}


def drawing(wiring: Wiring) -> Iterator[str]:
    """Yield the lines of the drawing, none wider than 100 columns; a full dot is a pad to which something goes."""
    edge = " " * (USES + NAME + 3)
    yield f"{edge}┌─────────┐"
    for left, right in zip(wiring.pads[::2], wiring.pads[1::2], strict=True):
        numbers = f"│{left.number:>3} │{right.number:>3} │"
        yield f"{_left(left, _uses(wiring, left))}{numbers}{_right(right, _uses(wiring, right))}"
    yield f"{edge}└─────────┘"
    yield f"{USED} used  {FREE} free    Pad 1 is at the corner of the board; the USB ports are at the other end."


def _uses(wiring: Wiring, pad: Pad) -> str:
    """Return which devices' signals go to a pad: ``left_motor + right_motor standby``."""
    here = [wire for wire in wiring.wires if wire.pads[:1] == (pad.number,)]
    by_signal = groupby(sorted(here, key=_signal), key=_signal)
    text = ", ".join(f"{' + '.join(wire.device for wire in wires)} {signal}" for signal, wires in by_signal)
    text = escape(text)
    return text if len(text) <= USES else f"{text[: USES - 1]}…"


def _signal(wire: Wire) -> str:
    return wire.signal


def _left(pad: Pad, uses: str) -> str:
    return f"{_bold(f'{uses:>{USES}}')} {_coloured(pad, f'{pad.name:>{NAME}} {_dot(uses)}')}"


def _right(pad: Pad, uses: str) -> str:
    name = f"{pad.name:<{NAME}} " if uses else pad.name
    return f"{_coloured(pad, f'{_dot(uses)} {name}')}{_bold(uses)}"


def _dot(uses: str) -> str:
    return USED if uses else FREE


def _coloured(pad: Pad, words: str) -> str:
    return click.style(words, STYLES.get(pad.name, STYLES.get(pad.kind.value)), bold=USED in words)


def _bold(words: str) -> str:
    return click.style(words, bold=True) if words.strip() else words
