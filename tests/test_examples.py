"""Every example in a docstring of the library and of the drivers runs and prints the result that it shows."""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def find_modules() -> list[str]:
    """Return the names of the modules that hold an example."""
    files = sorted(file for top in ("robotcore", "drivers") for file in (ROOT / top).rglob("*.py"))
    found = [file.relative_to(ROOT) for file in files if ">>> " in file.read_text(encoding="utf-8")]
    return [".".join(file.with_suffix("").parts).removesuffix(".__init__") for file in found]


@pytest.mark.slow
@pytest.mark.parametrize("name", find_modules())
def test_examples_in_the_docstrings_run(name: str) -> None:
    module = importlib.import_module(name)
    results = doctest.testmod(module)
    assert results.attempted > 0
    assert results.failed == 0
