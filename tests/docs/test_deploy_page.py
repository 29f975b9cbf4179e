from __future__ import annotations

import re
from pathlib import Path
from unittest.mock import create_autospec

import pytest

from robotcore.cli.main import execute
from robotcore.deploy import push as pushing
from tests.docs.listings import code_in, listings, rows

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "deploy.md").read_text()
WORDS = "\n".join(
    re.sub(r'"\s*\n\s*f?"', "", file.read_text()) for file in (ROOT / "robotcore" / "deploy").rglob("*.py")
)
"""The source, in which each string is in one piece."""


def test_the_listing_pushes_the_project_that_it_is_run_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert execute(["new", str(tmp_path / "my-robot")]) == 0
    monkeypatch.chdir(tmp_path / "my-robot")
    pushed = create_autospec(pushing.push)
    monkeypatch.setattr(pushing, "push", pushed)
    (listing,) = (each.text for each in listings(PAGE) if each.language == "python")
    exec(compile(listing, "deploy.md", "exec"), {})  # noqa: S102  the page's own
    (asked,) = pushed.call_args.args
    assert (str(asked.host), asked.project.name, asked.is_offline) == ("pi@rover.local", "my-robot", True)


@pytest.mark.parametrize("phrase", [phrase for row in rows(PAGE, "What a failure means") for phrase in code_in(row[0])])
def test_each_failure_is_reported_so(phrase: str) -> None:
    assert all(part in WORDS for part in map(str.strip, phrase.split("…")))
