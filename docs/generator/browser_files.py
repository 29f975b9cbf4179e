"""The generated files beside the page that runs an app in the browser: runs on Linux to compare, and the wheel."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from robotcore import RunRequest, run

DIST = Path(__file__).resolve().parents[2] / "dist"
"""The folder into which `make package` builds the wheel."""
APP = "green-search"
SEEDS = range(1, 8)
"""The seeds of the runs with which the page compares its own."""


def list_browser_files() -> Iterator[tuple[str, str | bytes]]:
    """Yield the names and the contents of the files. Without a built wheel, its file is left out."""
    yield "desk.json", json.dumps({seed: describe_run(seed) for seed in SEEDS})
    for wheel in sorted(DIST.glob("robotcore-*.whl"))[-1:]:
        yield "robotcore.whl", wheel.read_bytes()


def describe_run(seed: int) -> dict[str, str | int | None]:
    """Return the outcome, the number of ticks and the digest of a run on this machine."""
    result = run(RunRequest(APP, seed=seed))
    return {"outcome": result.outcome.value, "ticks": result.ticks, "digest": result.trace_sha256}
