"""The recorded table of a real server: every function's name, and every constant's value."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

RECORDED = Path(__file__).parents[1] / "recorded"


@cache
def table() -> dict[str, dict[str, Any]]:
    """Return it as the server sends it: ``{"func": {}}`` or ``{"const": value}`` by name."""
    content: dict[str, dict[str, Any]] = json.loads((RECORDED / "sim-info.json").read_text())
    return content


def constants() -> dict[str, Any]:
    """Return the constants by name."""
    return {name: entry["const"] for name, entry in table().items() if "const" in entry}
