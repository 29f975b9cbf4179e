from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from robotcore.fidelity.bounds import Bound
from robotcore.fidelity.fidelity import measure_fidelity
from robotcore.view.fidelity_table import build_rows
from tests.docs.listings import list_listings
from tests.robotcore.fidelity.drives import record

PAGE = (Path(__file__).parents[2] / "docs" / "fidelity.md").read_text()


@pytest.mark.slow
def test_the_listing_compares_a_run_with_its_simulation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (listing,) = (each.text for each in list_listings(PAGE) if each.language == "python")
    exec(compile(listing, "fidelity.md", "exec"), {})  # noqa: S102  the page's own
    assert float(capsys.readouterr().out) == 0.0


def test_the_page_shows_the_rows_and_the_measures_of_a_comparison() -> None:
    fidelity = measure_fidelity(record(timeout_s=1.0), "run.mcap")
    titles = {row[0] for row in build_rows(fidelity) if not row[0].startswith("eye")}
    assert titles == set(re.findall(r"^((?:path|left wheel|right wheel|nose), [\w %]+?)  ", PAGE, re.MULTILINE))
    (script,) = (each.text for each in list_listings(PAGE) if "--require" in each.text)
    words = shlex.split(script)
    bounds = [Bound.parse(words[at + 1]) for at, word in enumerate(words) if word == "--require"]
    assert bounds
    assert {bound.measure for bound in bounds} <= fidelity.measures.keys()
