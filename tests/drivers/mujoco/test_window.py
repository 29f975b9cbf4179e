from __future__ import annotations

import sys
from unittest.mock import MagicMock

import pytest

from drivers.mujoco.backend import MujocoBackend
from drivers.mujoco.window import WINDOW_LOCK
from robotcore.errors import BackendError
from tests.drivers.physics.worlds import setup, world
from tests.texts import Raises


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only X11 has the variable DISPLAY")
@pytest.mark.parametrize("display", ["", ":9999"], ids=["none", "no answer"])
def test_window_without_a_screen_is_refused(monkeypatch: pytest.MonkeyPatch, raises: Raises, display: str) -> None:
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setenv("DISPLAY", display)
    with raises(BackendError, "no-screen"):
        MujocoBackend().open(setup(world(), devices=["nose"], gui=True))


def test_second_window_is_refused_while_one_is_open(raises: Raises) -> None:
    with WINDOW_LOCK, raises(BackendError, "second-window"):
        MujocoBackend().open(setup(world(), devices=["nose"], gui=True))


def test_a_window_can_open_after_another_was_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.mujoco.window._require_screen", lambda: None)
    monkeypatch.setattr("drivers.mujoco.window._launch_viewer", lambda *_: (MagicMock(), set()))
    for _ in range(2):
        with MujocoBackend().open(setup(world(), devices=["nose"], gui=True)):
            assert WINDOW_LOCK.locked()
    assert not WINDOW_LOCK.locked()


def test_window_is_updated_at_most_every_40_ms_of_simulated_time(monkeypatch: pytest.MonkeyPatch) -> None:
    viewer = MagicMock()
    monkeypatch.setattr("drivers.mujoco.window._require_screen", lambda: None)
    monkeypatch.setattr("drivers.mujoco.window._launch_viewer", lambda *_: (viewer, set()))
    with MujocoBackend().open(setup(world(), devices=["nose"], gui=True)) as robot:
        for step in range(1, 241):
            robot.clock.sleep_until(step / 240)
    assert viewer.sync.call_count == pytest.approx(24, abs=1)
