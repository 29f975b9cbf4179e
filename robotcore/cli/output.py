"""Write lines, tables, JSON, findings and errors, with control characters escaped."""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Iterable, Sequence
from contextlib import ExitStack, nullcontext, redirect_stdout, suppress
from typing import TYPE_CHECKING, Any

import click

from robotcore.errors import BehaviourError, DescriptionError, Interrupted, RobotcoreError
from robotcore.text import escape, find_nearest

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderableType, RenderResult

    from robotcore.hal.check_finding import Finding


PIPED_WIDTH = 160
INDENT = "  "
"""Precedes an app's lines on stderr, to distinguish them from those of robotcore."""

_STDOUT, _STDERR = 1, 2

_STYLES = re.compile(r"(\x1b\[[0-9;]*m)")
"""Matches the escape sequences that `click.style` adds to a text."""

as_json = click.option("--json", "as_json", is_flag=True, help="Print one line of JSON instead.")
"""The option ``--json`` of a command."""


def write_json(data: Any) -> None:
    """Write one line of JSON. Its control characters are escaped."""
    click.echo(json.dumps(data))


def write_line(text: str = "", *, is_error: bool = False, is_styled: bool = False) -> None:
    """Write a text in one line. Control characters and line breaks are escaped.

    is_error: whether to write on stderr. A failure to write there is ignored, so that the result still reaches stdout.
    is_styled: whether to keep the colour sequences of `click.style`. The caller must escape untrusted text first.
    """
    parts = _STYLES.split(text) if is_styled else [text]
    line = "".join(part if index % 2 else escape(part, keep="\t") for index, part in enumerate(parts))
    with suppress(OSError) if is_error else nullcontext():
        click.echo(line, err=is_error)


def write_prompt(text: str) -> None:
    """Write a text on stderr without a line break, for an answer behind it."""
    click.echo(escape(text), err=True, nl=False)


def write_lines(text: str, *, indent: str = "", is_error: bool = False) -> None:
    """Write each line of a text, with ``indent`` before it."""
    for line in text.split("\n"):
        write_line(f"{indent}{line}" if line else "", is_error=is_error)


def write_content(text: str) -> None:
    """Write the content of a file unchanged, so that another program can read it."""
    click.echo(text, nl=False)


def redirect_prints(*, as_json: bool) -> ExitStack:
    """Redirect stdout to stderr if ``as_json`` is True, until the returned stack is closed.

    So the prints of an app and of its subprocesses go to stderr, and stdout has only JSON.
    """
    stack = ExitStack()
    if as_json and sys.stdout and sys.stderr:  # else the file descriptor 1 or 2 may be that of another file
        descriptor = os.dup(_STDOUT)
        stack.callback(os.close, descriptor)
        stack.callback(os.dup2, descriptor, _STDOUT)
        stack.callback(sys.stdout.flush)
        os.dup2(_STDERR, _STDOUT)
    if as_json:
        stack.enter_context(redirect_stdout(sys.stderr))
    return stack


def write_table(columns: Sequence[str], rows: Iterable[Sequence[RenderableType]]) -> None:
    """Write a table. Its first column, which has the names of the rows, is not wrapped."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, header_style="bold")
    for index, column in enumerate(columns):
        table.add_column(column, style="cyan" if index == 0 else "", no_wrap=index == 0)
    for row in rows:
        table.add_row(*(escape(cell, keep="\n") if isinstance(cell, str) else cell for cell in row))
    write(table)


def write(renderable: RenderableType, *, is_error: bool = False) -> None:
    """Write a renderable of the library rich, with the colours and the width of the terminal.

    In a pipe it has no colours, and its width is `PIPED_WIDTH`.

    is_error: whether to write on stderr.
    """
    from rich.console import Console

    stream = sys.stderr if is_error else sys.stdout
    width = None if stream and stream.isatty() else PIPED_WIDTH
    console = Console(highlight=False, markup=False, emoji=False, width=width)
    with console.capture() as capture:
        console.print(_EscapedRenderable(renderable))
    click.echo(capture.get(), nl=False, err=is_error)


class _EscapedRenderable:
    def __init__(self, renderable: RenderableType) -> None:
        self._renderable = renderable

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for segment in console.render(self._renderable, options):
            yield segment._replace(text=escape(segment.text, keep="\n"))


def write_failure(message: str) -> None:
    """Write an error message on stderr. Its lines after the first are indented."""
    first, *others = message.split("\n")
    write_line(f"{click.style('error:', fg='red', bold=True)} {escape(first)}", is_error=True, is_styled=True)
    for line in others:
        write_line(f"{INDENT}{line}", is_error=True)


def write_error(error: RobotcoreError | Interrupted) -> None:
    """Write an error on stderr. Each problem in a file has its own line. An app's error follows its traceback."""
    if isinstance(error, BehaviourError) and error.traceback:
        write_lines(error.traceback.rstrip("\n"), indent=INDENT, is_error=True)
    problems = str(error).split("\n") if isinstance(error, DescriptionError) else [str(error)]
    for problem in problems:
        write_failure(problem)


def write_usage_error(error: click.ClickException) -> None:
    """Write an error in a command's arguments on stderr, and the command that shows its help."""
    context = getattr(error, "ctx", None)
    write_failure(format_usage_error(error))
    write_line(f"Try '{context.command_path if context else 'robotcore'} --help'.", is_error=True)


def format_usage_error(error: click.ClickException) -> str:
    """Return the message of an error in a command's arguments. For an unknown option, it suggests only a near name."""
    if not isinstance(error, click.NoSuchOption) or error.ctx is None:
        return error.format_message()
    options = (each for each in error.ctx.command.get_params(error.ctx) if isinstance(each, click.Option))
    nearest = find_nearest(error.option_name, [name for option in options for name in option.opts])
    return f"unknown option {error.option_name!r}.{f' Did you mean {nearest!r}?' if nearest else ''}"


FINDING_STYLES = {"ok": "green", "warning": "yellow", "error": "red"}
NEWLINE, FINDING_INDENT, FINDING_WIDTH = "\n", 23, 1000


def write_finding(finding: Finding) -> None:
    """Write a finding and its remedy, wrapped to the terminal's width. In a pipe the lines are not wrapped."""
    from shutil import get_terminal_size

    width = max(get_terminal_size().columns, 2 * FINDING_INDENT) if sys.stdout.isatty() else FINDING_WIDTH
    level = finding.level.value
    lines = click.wrap_text(
        f"{level:<9}{finding.subject + ' ':<14}{_join_lines(finding.message)}", width, "", " " * FINDING_INDENT
    )
    if finding.remedy:
        lines += NEWLINE + click.wrap_text(
            _join_lines(finding.remedy), width, f"{'→':>{FINDING_INDENT - 1}} ", " " * FINDING_INDENT
        )
    for line in map(escape, lines.split(NEWLINE)):
        styled = line.replace(level, click.style(level, FINDING_STYLES[level]), 1) if line.startswith(level) else line
        write_line(styled, is_styled=True)


def _join_lines(words: str) -> str:
    return " ".join(words.split())
