"""The program on the page about driving by hand works."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.cli.driving_keys import DIRECTIONS, FIRST_S, HELP, REPEAT_S, SPEEDS, TAP_SCALE
from robotcore.runtime.operator_input import LEASE_S, MAX_VELOCITY
from tests.docs.listings import list_listings, read_rows

PAGE = (Path(__file__).parents[2] / "docs" / "teleop.md").read_text()
(PROGRAM,) = (each for each in list_listings(PAGE) if each.language == "python")


def test_program_drives_and_returns_the_robot(capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(PROGRAM.text, PROGRAM.file, "exec", dont_inherit=True), {"__name__": "driven_by_hand"})  # noqa: S102
    assert capsys.readouterr().out == "success after 5.0 s\n"


def test_page_has_the_keys_and_their_times() -> None:
    keys = ",".join(key for key, _ in read_rows(PAGE, "Keys")).lower()
    assert all(f"{key}," in f"{keys}," for key in DIRECTIONS)
    assert f"{FIRST_S:g} s, at half" in PAGE.replace("\n", " ")
    assert TAP_SCALE == 0.5
    assert f"within {REPEAT_S:g} s" in PAGE
    assert f"{SPEEDS[0]:.0%}".replace("%", " %") in PAGE
    assert f"holds for {LEASE_S:g} s" in PAGE
    assert f"above {MAX_VELOCITY:g}" in PAGE
    assert "Q and E" in HELP
