from __future__ import annotations

import doctest

from robotcore.testing import fakes


def test_examples_in_docstrings_run() -> None:
    assert doctest.testmod(fakes) == doctest.TestResults(failed=0, attempted=3)
