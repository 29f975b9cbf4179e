from __future__ import annotations

import re
from pathlib import Path

import pytest

from robotcore.hardware.firmware.board import shipped_sketch

PAGE = (Path(__file__).parents[2] / "docs" / "firmware.md").read_text()
CONFIG = dict(re.findall(r"(?m)^#define (\w+) (\S+)", (shipped_sketch() / "config.h").read_text()))
COMMANDS = (shipped_sketch() / "commands.cpp").read_text()


def test_pins_are_those_of_the_sketch() -> None:
    rows = re.findall(r"(?m)^\| .* \| (.*) \| `(\w+_PIN)` \|$", PAGE)
    assert {name: "NOT_WIRED" if where.startswith("none") else where for where, name in rows} == {
        name: pin for name, pin in CONFIG.items() if name.endswith("_PIN")
    }


def test_every_command_of_the_sketch_has_a_row_and_no_other() -> None:
    known = set(re.findall(r"case '(\w)':|command\.name == '(p)'", COMMANDS))
    assert set(re.findall(r"(?m)^\| `(\w)[ `]", PAGE)) == {letter for pair in known for letter in pair if letter}


@pytest.mark.parametrize("name", ["BAUD", "DEADMAN_MS"])
def test_page_has_the_values_of_the_sketch(name: str) -> None:
    assert f"{CONFIG[name]} {name.removeprefix('DEADMAN_').lower()}" in PAGE
