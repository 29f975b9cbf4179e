"""What commands write on stdout: a line of JSON, or something drawn by rich."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext, redirect_stdout
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.console import RenderableType

PIPED_WIDTH = 160

as_json = click.option("--json", "as_json", is_flag=True, help="Print one line of JSON instead.")
"""The option that every list has."""


def write_json(data: Any) -> None:
    """Write one line of JSON."""
    click.echo(json.dumps(data))


def printing_apart(*, as_json: bool) -> AbstractContextManager[object]:
    """While entered, what an app prints goes to stderr where stdout is for a line of JSON alone."""
    return redirect_stdout(sys.stderr) if as_json else nullcontext()


def write_table(columns: Sequence[str], rows: Iterable[Sequence[RenderableType]]) -> None:
    """Write a table; its first column holds names."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, header_style="bold")
    for index, column in enumerate(columns):
        table.add_column(column, style="cyan" if index == 0 else "", no_wrap=index == 0)
    for row in rows:
        table.add_row(*row)
    write(table)


def write(renderable: RenderableType) -> None:
    """Write what rich can draw: coloured and as wide as the terminal, or plain and in long lines."""
    from rich.console import Console

    console = Console(highlight=False, markup=False, width=None if sys.stdout and sys.stdout.isatty() else PIPED_WIDTH)
    with console.capture() as capture:
        console.print(renderable)
    click.echo(capture.get(), nl=False)
