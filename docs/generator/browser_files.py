"""The generated files beside the page that runs an app in the browser: the digests of the desk, and the wheel."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from robotcore import RunRequest, run

DIST = Path(__file__).resolve().parents[2] / "dist"
"""The folder into which `make package` builds the wheel."""
APP = "green-search"
SEEDS = range(1, 8)
"""The seeds whose digests the page shows."""


def list_browser_files() -> Iterator[tuple[str, str | bytes]]:
    """Yield the names and the contents of the files. Without a built wheel, its file is left out."""
    digests = {seed: run(RunRequest(APP, seed=seed)).trace_sha256 for seed in SEEDS}
    yield "desk.json", json.dumps(digests)
    for wheel in sorted(DIST.glob("robotcore-*.whl"))[-1:]:
        yield "robotcore.whl", wheel.read_bytes()
