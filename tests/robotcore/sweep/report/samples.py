"""Records of runs for reports, and pages made of them."""

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
WAY: TruePath = ((0.0, -1.0, 0.0), (0.5, 0.0, 0.5), (1.0, 1.0, 1.5))


def passed(*, path: TruePath | None = WAY, **changes: Any) -> Record:
    result = replace(PASSED, **changes)
    return Record(result, path, f"robotcore run green-search --seed {result.seed}")


def failed(*, path: TruePath | None = WAY, picture: str | None = None, **changes: Any) -> Record:
    ended = {
        "outcome": Outcome.TIMEOUT,
        "verified": False,
        "reason": "not done after 20 s",
        "milestones": {"search": 0.0},
    }
    return replace(passed(path=path, **{**ended, **changes}), picture=picture)


def many(runs: int, failing: int, **changes: Any) -> list[Record]:
    """Return so many runs, the first of them failing, on paths that wander."""
    steps = np.random.default_rng(1).normal(0, 0.1, (runs, 2, 40)).cumsum(axis=2)
    times = np.arange(40) / 2
    paths = (tuple(zip(times.tolist(), *xy.tolist(), strict=True)) for xy in steps)
    makers = [failed] * failing + [passed] * (runs - failing)
    pairs = zip(makers, paths, strict=True)
    return [make(seed=seed, path=path, **changes) for seed, (make, path) in enumerate(pairs, start=1)]


VOID = {"meta", "img", "br"}


class Page(HTMLParser):
    """Takes a page apart: ``attributes`` of all elements, ``words`` between them, ``faults`` in how they nest."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.faults: list[str] = []
        self.words = ""
        self._open: list[str] = []
        self.feed(html)
        self.close()
        self.faults += [f"<{tag}> is never closed" for tag in self._open]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_startendtag(tag, attrs)
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(tag, name, value or "") for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        if not self._open or self._open.pop() != tag:
            self.faults.append(f"</{tag}> closes nothing at {self.getpos()}")

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] != "style":
            self.words += data

    def values(self, tag: str, name: str) -> list[str]:
        """Return an attribute of every element of a kind."""
        return [value for each, attribute, value in self.attributes if (each, attribute) == (tag, name)]
