from __future__ import annotations

import sys

import pytest

from robotcore.cli.doctor.machine import numpy, opencv, python
from robotcore.hal.finding import Level


def test_this_machine_is_fit_for_these_tests() -> None:
    found = [*numpy(), *opencv()]
    assert [(each.what, each.level) for each in found] == [("NumPy", Level.OK), ("OpenCV", Level.OK)]


@pytest.mark.parametrize("version, level", [((3, 9, 2), "warning"), ((3, 10, 0), "ok"), ((3, 14, 0), "warning")])
def test_a_python_that_nobody_tests_is_a_warning(
    monkeypatch: pytest.MonkeyPatch, version: tuple[int, int, int], level: str
) -> None:
    monkeypatch.setattr(sys, "version_info", version)
    (found,) = python()
    assert found.level.value == level
    assert bool(found.remedy) is (level == "warning")


def test_an_opencv_that_was_built_for_another_numpy_is_an_error_with_a_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    (found,) = opencv()
    assert found.level is Level.ERROR
    assert found.said.startswith("does not work: ModuleNotFoundError: ")
    assert "python3-opencv" in found.remedy
