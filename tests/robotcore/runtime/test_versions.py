"""test_versions."""

from __future__ import annotations

import platform

import numpy as np
import pytest

from robotcore.runtime import versions


def test_libraries_count_also_where_python_does_not_know_who_brought_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(versions, "_owners", dict)
    assert versions.libraries(()) == {"python": platform.python_version(), "numpy": np.__version__}
