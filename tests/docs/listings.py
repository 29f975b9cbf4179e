"""Parse the listings and tables of a Markdown page, and compare the output of its commands with the page."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from textwrap import dedent
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
PATTERNS = (
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "docs/**/*.md",
    "drivers/**/*.md",
    "robotcore/cli/scaffold/templates/*/*.md",
    "tests/system/README.md",
)
FENCE = re.compile(r"^( *)```(\w*)[^\n`]*\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)
DECIMAL = re.compile(r"(\d+\.\d+)")
CODE = re.compile(r"`([^`]+)`")


class Listing(NamedTuple):
    """A fenced block of a page, with its language and its text."""

    language: str
    text: str

    @property
    def file(self) -> str:
        """The file whose name is in the first line of the listing."""
        return self.text.partition("\n")[0].removeprefix("# ")


class ConsoleCommand(NamedTuple):
    """A command in a console listing and its output on the page, in which ``…`` matches any text."""

    command: str
    answer: str

    def matches(self, answer: str) -> bool:
        """Return whether an output has the words of the page, and each decimal number within 10 %.

        The tolerance allows for the differences between versions of OpenCV.
        """
        found = re.fullmatch(_pattern(self.answer), " ".join(answer.split()))
        expected = DECIMAL.findall(self.answer)
        return found is not None and list(map(float, found.groups())) == pytest.approx(
            list(map(float, expected)), rel=0.1
        )


def list_listings(page: str) -> list[Listing]:
    """Return the fenced blocks of a page, from the first to the last."""
    return [Listing(language, dedent(text)) for _, language, text in FENCE.findall(page)]


def read_pages() -> dict[str, str]:
    """Return the texts of all pages of the project, by their files relative to its folder."""
    files = sorted(file for pattern in PATTERNS for file in ROOT.glob(pattern))
    return {file.relative_to(ROOT).as_posix(): file.read_text(encoding="utf-8") for file in files}


def list_commands(page: str) -> list[ConsoleCommand]:
    """Return the commands of all console listings of a page, with their outputs."""
    consoles = (listing.text for listing in list_listings(page) if listing.language == "console")
    parts = (part for console in consoles for part in re.split(r"^\$ ", console, flags=re.MULTILINE)[1:])
    return [ConsoleCommand(*part.partition("\n")[::2]) for part in parts]


def write_files(listings: Iterable[Listing], folder: Path) -> None:
    """Write the Python files of a page into a folder."""
    for listing in listings:
        if listing.language == "python":
            (folder / listing.file).write_text(listing.text, encoding="utf-8")


def read_rows(page: str, heading: str) -> list[list[str]]:
    """Return the cells of each row of the tables below a heading, without their head rows."""
    section = page.partition(f"# {heading}\n")[2].partition("\n## ")[0]
    tables = re.findall(r"^\|.*\n\| ---.*\n((?:\|.*\n)+)", section, re.MULTILINE)
    return [[cell.strip() for cell in row.strip("|").split("|")] for table in tables for row in table.splitlines()]


def find_code(text: str) -> list[str]:
    """Return the texts in backquotes that are outside of fenced blocks."""
    return CODE.findall(FENCE.sub("", text))


def list_missing_attributes(page: str, value: object) -> set[str]:
    """Return the public attributes of a value that the page does not name in backquotes."""
    named = {word for code in find_code(page) for word in code.replace("(", ".").split(".")}
    return {name for name in dir(value) if not name.startswith("_")} - named


def _pattern(answer: str) -> str:
    parts = DECIMAL.split(" ".join(answer.split()))
    return r"(\d+\.\d+)".join(re.escape(part).replace("…", ".*?") for part in parts[::2])
