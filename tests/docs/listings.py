"""Parses the listings and tables of a Markdown page, and compares a command's output with the page."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

import pytest

FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
DECIMAL = re.compile(r"(\d+\.\d+)")
CODE = re.compile(r"`([^`]+)`")


class Listing(NamedTuple):
    """A fenced block: its language and its text."""

    language: str
    text: str

    @property
    def file(self) -> str:
        """The file that the first line names."""
        return self.text.partition("\n")[0].removeprefix("# ")


class Exchange(NamedTuple):
    """A command of a console and its output on the page. ``…`` matches any text."""

    command: str
    answer: str

    def is_answered_by(self, answer: str) -> bool:
        """Return whether an output has the words of the page, and each decimal within a tenth.

        The tolerance is for versions of OpenCV, which differ a little.
        """
        found = re.fullmatch(_pattern(self.answer), " ".join(answer.split()))
        expected = DECIMAL.findall(self.answer)
        return found is not None and list(map(float, found.groups())) == pytest.approx(
            list(map(float, expected)), rel=0.1
        )


def listings(page: str) -> list[Listing]:
    """Return the fenced blocks of a page, in order."""
    return [Listing(*block) for block in FENCE.findall(page)]


def exchanges(console: str) -> Iterator[Exchange]:
    """Yield the commands of a console listing."""
    for part in re.split(r"^\$ ", console, flags=re.MULTILINE)[1:]:
        command, _, answer = part.partition("\n")
        yield Exchange(command, answer)


def rows(page: str, heading: str) -> list[list[str]]:
    """Return the cells of the tables below a heading, without the head rows."""
    section = page.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    tables = re.findall(r"^\|.*\n\| ---.*\n((?:\|.*\n)+)", section, re.MULTILINE)
    return [[cell.strip() for cell in row.strip("|").split("|")] for table in tables for row in table.splitlines()]


def code_in(text: str) -> list[str]:
    """Return the texts in backquotes, without those of fenced blocks."""
    return CODE.findall(FENCE.sub("", text))


def _pattern(answer: str) -> str:
    parts = DECIMAL.split(" ".join(answer.split()))
    return r"(\d+\.\d+)".join(re.escape(part).replace("…", ".*?") for part in parts[::2])
