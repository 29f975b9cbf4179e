"""The listings and tables of a Markdown page, and whether what a command told is what the page says."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

import pytest

FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
DECIMAL = re.compile(r"(\d+\.\d+)")
CODE = re.compile(r"`([^`]+)`")


class Listing(NamedTuple):
    """A fenced block: its language, and what stands in it."""

    language: str
    text: str

    @property
    def file(self) -> str:
        """The file that the first line names."""
        return self.text.partition("\n")[0].removeprefix("# ")


class Exchange(NamedTuple):
    """A command of a console, and what is told for it; ``…`` is anything."""

    command: str
    answer: str

    def is_answered_by(self, answer: str) -> bool:
        """Return whether the words are these, and each decimal within a tenth: versions of OpenCV differ a little."""
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
    """Return the cells of the tables below a heading, their heads left out."""
    section = page.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    tables = re.findall(r"^\|.*\n\| ---.*\n((?:\|.*\n)+)", section, re.MULTILINE)
    return [[cell.strip() for cell in row.strip("|").split("|")] for table in tables for row in table.splitlines()]


def code_in(text: str) -> list[str]:
    """Return what is set as code within a line."""
    return CODE.findall(FENCE.sub("", text))


def _pattern(answer: str) -> str:
    parts = DECIMAL.split(" ".join(answer.split()))
    return r"(\d+\.\d+)".join(re.escape(part).replace("…", ".*?") for part in parts[::2])
