from __future__ import annotations

import platform
import sys

import pytest

from robotcore.cli.doctor.machine import check_processor, check_python, check_system, list_machine_checks
from robotcore.hal.check_finding import Finding, Level
from tests.texts import CheckText


def find_library(name: str) -> Finding:
    (found,) = dict(list_machine_checks())[name]()
    return found


def test_numpy_and_opencv_work_here() -> None:
    found = [find_library(name) for name in ("NumPy", "OpenCV")]
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


def test_a_python_of_32_bits_is_a_warning(monkeypatch: pytest.MonkeyPatch, check_text: CheckText) -> None:
    assert list(check_processor()) == []
    monkeypatch.setattr(sys, "maxsize", 2**31 - 1)
    monkeypatch.setattr(platform, "machine", lambda: "aarch64")
    (found,) = check_processor()
    assert (found.kind, found.level) == ("processor-untested", Level.WARNING)
    check_text(f"{found.message}. {found.remedy}")


@pytest.mark.parametrize("name, module", [("NumPy", "numpy"), ("OpenCV", "cv2")])
def test_a_broken_library_is_an_error_with_a_remedy(
    monkeypatch: pytest.MonkeyPatch, name: str, module: str, check_text: CheckText
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    found = find_library(name)
    assert (found.kind, found.level) == ("library-broken", Level.ERROR)
    check_text(found.remedy)


@pytest.mark.parametrize("is_linux, kinds", [(True, []), (False, ["system-untested"])])
def test_another_system_than_linux_is_a_warning(
    monkeypatch: pytest.MonkeyPatch, is_linux: bool, kinds: list[str]
) -> None:
    monkeypatch.setattr("robotcore.cli.doctor.machine.IS_LINUX", is_linux)
    assert [finding.kind for finding in check_system()] == kinds
