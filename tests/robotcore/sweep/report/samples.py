"""Records of runs for the tests of reports, and a parser of HTML pages."""

from __future__ import annotations

from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import numpy as np

from robotcore.runtime.result import Outcome, RunResult
from robotcore.sweep.record import Record, TruePath

PASSED = RunResult(
    "green-search",
    "kinematic",
    "rover",
    "arena",
    seed=7,
    outcome=Outcome.SUCCESS,
    exit_status=0,
    verified=True,
    sim_time_s=20.0,
    contacts=0,
    milestones={"search": 0.0, "seen": 5.0, "arrived": 19.0},
)
PATH: TruePath = ((0.0, -1.0, 0.0), (0.5, 0.0, 0.5), (1.0, 1.0, 1.5))


def make_pass(*, path: TruePath | None = PATH, **changes: Any) -> Record:
    result = replace(PASSED, **changes)
    return Record(result, path, f"robotcore run green-search --seed {result.seed}")


def make_fail(*, path: TruePath | None = PATH, picture: str | None = None, **changes: Any) -> Record:
    ended = {
        "outcome": Outcome.TIMEOUT,
        "verified": False,
        "reason": "not done after 20 s",
        "milestones": {"search": 0.0},
    }
    return replace(make_pass(path=path, **{**ended, **changes}), picture=picture)


def make_many(runs: int, failing: int, **changes: Any) -> list[Record]:
    """Return records of runs on random paths. The first ``failing`` runs fail."""
    steps = np.random.default_rng(1).normal(0, 0.1, (runs, 2, 40)).cumsum(axis=2)
    times = np.arange(40) / 2
    paths = (tuple(zip(times.tolist(), *xy.tolist(), strict=True)) for xy in steps)
    makers = [make_fail] * failing + [make_pass] * (runs - failing)
    pairs = zip(makers, paths, strict=True)
    return [make(seed=seed, path=path, **changes) for seed, (make, path) in enumerate(pairs, start=1)]


VOID = {"meta", "img", "br"}


class Page(HTMLParser):
    """The elements and texts of an HTML page."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        """The tags of all elements."""
        self.attributes: list[tuple[str, str, str]] = []
        """The tag, the name and the value of all attributes."""
        self.mistakes: list[str] = []
        """Messages about start tags without an end tag, and end tags without a start tag."""
        self.words = ""
        """The text of the page, without styles."""
        self.sections: list[str] = [""]
        """The text before the first ``h2`` heading, then the text from each ``h2`` heading to the next one."""
        self._open: list[str] = []
        self.feed(html)
        self.close()
        self.mistakes += [f"<{tag}> is never closed" for tag in self._open]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_startendtag(tag, attrs)
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        if tag == "h2":
            self.sections.append("")
        self.attributes += [(tag, name, value or "") for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        if not self._open or self._open.pop() != tag:
            self.mistakes.append(f"</{tag}> closes nothing at {self.getpos()}")

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] != "style":
            self.words += data
            self.sections[-1] += data

    def section(self, heading: str) -> str:
        """Return the text of the section with a heading, without blank lines; of the head for ``""``."""
        (found,) = [text for text in self.sections[1:] if text.startswith(heading)] if heading else self.sections[:1]
        return "\n".join(filter(None, map(str.strip, found.splitlines())))

    def values(self, tag: str, name: str) -> list[str]:
        """Return the values of an attribute in all elements with a tag."""
        return [value for each, attribute, value in self.attributes if (each, attribute) == (tag, name)]
