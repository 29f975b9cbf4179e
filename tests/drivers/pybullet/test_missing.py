from __future__ import annotations

import platform
import sys

import pytest

from drivers.pybullet.backend import PyBulletBackend
from robotcore.errors import BackendMissingError
from tests.drivers.physics.worlds import setup, world
from tests.texts import Raises


@pytest.fixture(autouse=True)
def _no_pybullet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PyBulletBackend, "modules", ("no_such_library",))


def test_missing_library_is_reported() -> None:
    with pytest.raises(BackendMissingError):
        PyBulletBackend().open(setup(world()))


@pytest.mark.parametrize(
    "version, processor",
    [((3, 10), "x86_64"), ((3, 11), "AMD64"), ((3, 12), "x86_64"), ((3, 11), "aarch64")],
    ids=["3.10 x86_64", "3.11 AMD64", "3.12 x86_64", "3.11 aarch64"],
)
def test_remedy_fits_the_machine(
    version: tuple[int, int], processor: str, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr(sys, "version_info", version)
    monkeypatch.setattr(platform, "machine", lambda: processor)
    with raises(BackendMissingError, hide=[platform.python_version()]):
        PyBulletBackend().require_installed()
