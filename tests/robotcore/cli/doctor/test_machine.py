from __future__ import annotations

import sys

import pytest

from robotcore.cli.doctor.machine import check_numpy, check_opencv, check_python
from robotcore.hal.check_finding import Level
from tests.texts import CheckText


def test_numpy_and_opencv_work_here() -> None:
    found = [*check_numpy(), *check_opencv()]
    assert [(each.kind, each.level) for each in found] == [("numpy-works", Level.OK), ("opencv-works", Level.OK)]


@pytest.mark.parametrize(
    "version, kind",
    [((3, 9, 2), "python-untested"), ((3, 10, 0), "python-tested"), ((3, 14, 0), "python-untested")],
)
def test_an_untested_python_is_a_warning(
    monkeypatch: pytest.MonkeyPatch, version: tuple[int, int, int], kind: str
) -> None:
    monkeypatch.setattr(sys, "version_info", version)
    (found,) = check_python()
    assert found.kind == kind
    assert found.level is (Level.WARNING if found.remedy else Level.OK)


def test_an_opencv_that_was_built_for_another_numpy_is_an_error_with_a_remedy(
    monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    (found,) = check_opencv()
    assert (found.kind, found.level) == ("library-broken", Level.ERROR)
    check_text(found.remedy)
