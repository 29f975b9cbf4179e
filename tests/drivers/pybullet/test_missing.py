from __future__ import annotations

import platform
import sys

import pytest

from drivers.pybullet.backend import PyBulletBackend
from robotcore.errors import BackendMissingError
from tests.drivers.physics.worlds import setup, world


@pytest.fixture(autouse=True)
def _no_pybullet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PyBulletBackend, "modules", ("no_such_library",))


def test_without_the_library_nothing_opens() -> None:
    with pytest.raises(BackendMissingError, match="'pybullet' is not installed"):
        PyBulletBackend().open(setup(world()))


@pytest.mark.parametrize(
    "version, processor, advice",
    [
        ((3, 10), "x86_64", r'pip install "robotcore\[sim\]"'),
        ((3, 11), "AMD64", r'pip install "robotcore\[sim\]"'),
        ((3, 12), "x86_64", "no wheel for Python .* take --backend mujoco, .* or Python 3.11"),
        ((3, 11), "aarch64", "no wheel for .* on aarch64; take --backend mujoco"),
    ],
)
def test_the_remedy_is_one_that_works_on_this_machine(
    version: tuple[int, int], processor: str, advice: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "version_info", version)
    monkeypatch.setattr(platform, "machine", lambda: processor)
    with pytest.raises(BackendMissingError, match=advice):
        PyBulletBackend().require_installed()
