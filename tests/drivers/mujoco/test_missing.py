from __future__ import annotations

import pytest

from drivers.mujoco.backend import MujocoBackend
from robotcore.errors import BackendMissingError
from tests.drivers.physics.worlds import setup, world


def test_without_the_library_nothing_opens_and_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(MujocoBackend, "modules", ("no_such_library",))
    with pytest.raises(BackendMissingError, match=r"'mujoco' is not installed.*pip install \"robotcore\[sim\]\""):
        MujocoBackend().open(setup(world()))
