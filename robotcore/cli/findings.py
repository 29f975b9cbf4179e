"""How a finding is written in a terminal."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import click

from robotcore.cli.output import write_line
from robotcore.text import escape

if TYPE_CHECKING:
    from robotcore.hal.finding import Finding

STYLES = {"ok": "green", "warning": "yellow", "error": "red"}
NEWLINE, INDENT, PIPED_WIDTH = "\n", 23, 1000


def write_finding(finding: Finding) -> None:
    """Write a finding, and its remedy below it, as wide as the terminal, or in long lines."""
    from shutil import get_terminal_size

    width = max(get_terminal_size().columns, 2 * INDENT) if sys.stdout.isatty() else PIPED_WIDTH
    level = finding.level.value
    lines = click.wrap_text(f"{level:<9}{finding.what:<14}{_in_one_line(finding.said)}", width, "", " " * INDENT)
    if finding.remedy:
        lines += NEWLINE + click.wrap_text(_in_one_line(finding.remedy), width, f"{'→':>{INDENT - 1}} ", " " * INDENT)
    for line in map(escape, lines.split(NEWLINE)):
        styled = line.replace(level, click.style(level, STYLES[level]), 1) if line.startswith(level) else line
        write_line(styled, is_styled=True)


def _in_one_line(words: str) -> str:
    return " ".join(words.split())
