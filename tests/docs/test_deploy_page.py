from __future__ import annotations

import re
from pathlib import Path
from unittest.mock import create_autospec

import pytest

from robotcore.cli.main import execute
from robotcore.deploy import push as pushing
from tests.docs.listings import find_code, list_listings, read_rows

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "deploy.md").read_text()
WORDS = "\n".join(
    re.sub(r'"\s*\n\s*f?"', "", file.read_text()) for file in (ROOT / "robotcore" / "deploy").rglob("*.py")
)
"""The source of `robotcore.deploy`, in which strings over several lines are joined."""


def test_the_listing_pushes_the_project_in_the_current_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert execute(["new", str(tmp_path / "my-robot")]) == 0
    monkeypatch.chdir(tmp_path / "my-robot")
    pushed = create_autospec(pushing.push)
    monkeypatch.setattr(pushing, "push", pushed)
    (listing,) = (each.text for each in list_listings(PAGE) if each.language == "python")
    exec(compile(listing, "deploy.md", "exec"), {})  # noqa: S102  the page's own
    (asked,) = pushed.call_args.args
    assert (str(asked.host), asked.project.name, asked.is_offline) == ("pi@rover.local", "my-robot", True)


def test_each_failure_has_the_message_on_the_page() -> None:
    for row in read_rows(PAGE, "What a failure means"):
        for phrase in find_code(row[0]):
            assert all(part in WORDS for part in map(str.strip, phrase.split("…"))), phrase
