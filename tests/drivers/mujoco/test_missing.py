from __future__ import annotations

from importlib.metadata import requires

import mujoco
import pytest

from drivers.mujoco.backend import OLDEST, MujocoBackend
from robotcore.errors import BackendMissingError
from tests.drivers.physics.worlds import setup, world


def test_without_the_library_nothing_opens_and_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(MujocoBackend, "modules", ("no_such_library",))
    with pytest.raises(BackendMissingError, match=r"'mujoco' is not installed.*pip install \"robotcore\[sim\]\""):
        MujocoBackend().open(setup(world()))


@pytest.mark.parametrize("version", ["3.4.0", "2.10.1"])
def test_a_library_that_is_too_old_is_told_with_what_to_install(monkeypatch: pytest.MonkeyPatch, version: str) -> None:
    monkeypatch.setattr(mujoco, "__version__", version)
    with pytest.raises(BackendMissingError, match=rf"MuJoCo {version} is too old.*pip install --upgrade"):
        MujocoBackend().require_installed()


def test_the_oldest_that_works_is_the_oldest_that_is_installed() -> None:
    assert any(line.startswith("mujoco>={}.{};".format(*OLDEST)) for line in requires("robotcore") or ())
