from __future__ import annotations

import doctest

from robotcore.testing import gate


def test_examples_in_docstrings_run() -> None:
    assert doctest.testmod(gate) == doctest.TestResults(failed=0, attempted=3)
