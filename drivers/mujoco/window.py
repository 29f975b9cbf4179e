"""MuJoCo's window, which shows a simulation."""

from __future__ import annotations

import threading
import warnings
from contextlib import ExitStack
from copy import copy
from typing import TYPE_CHECKING

from robotcore.errors import BackendError

if TYPE_CHECKING:
    from mujoco import MjData, MjModel
    from mujoco.viewer import Handle

NO_SCREEN = "mujoco: there is no screen for a window. Leave --gui out, or set DISPLAY to a screen"

AZIMUTH_DEG, ELEVATION_DEG, DISTANCE_RATIO = 90.0, -60.0, 1.45
"""The first view: from the south of the world, down on its middle. The distance is in widths of the world."""

CLOSING_S = 5.0
"""Time limit of the wait for the end of the window's thread, in seconds."""

WINDOW_LOCK = threading.Lock()
"""A lock that the open window holds. Each window has its own thread, and GLFW crashes if two threads use it."""


class Window:
    """Shows a copy of the robot and the world. The user's actions in the window do not change the run."""

    def __init__(self, model: MjModel, data: MjData, width_m: float) -> None:
        """Open the window.

        width_m: the width of the world in metres.

        Raises BackendError if no window can open, or if another one is open.
        """
        self._model, self._data, self._shown = copy(model), data, copy(data)
        if not WINDOW_LOCK.acquire(blocking=False):
            raise BackendError(
                "mujoco: another window is open, and only one can be. Close the other robot first, or leave --gui out",
                kind="second-window",
            )
        with ExitStack() as cleanup:
            cleanup.callback(WINDOW_LOCK.release)
            _require_screen()
            self._viewer, self._threads = _launch_viewer(self._model, self._shown)
            self._closing = cleanup.pop_all()
        with self._viewer.lock():
            camera = self._viewer.cam
            camera.lookat[:], camera.distance = 0.0, DISTANCE_RATIO * width_m
            camera.azimuth, camera.elevation = AZIMUTH_DEG, ELEVATION_DEG

    def show(self) -> None:
        """Show the current state. Raises BackendError if the user has closed the window."""
        from mujoco import mj_copyData

        if not self._viewer.is_running():
            raise BackendError("mujoco: the window was closed. Run again and leave it open", kind="window-closed")
        mj_copyData(self._shown, self._model, self._data)
        self._viewer.sync()

    def close(self) -> None:
        """Close the window and wait for its thread. It may be called again."""
        self._viewer.close()
        for thread in self._threads:
            thread.join(CLOSING_S)
        self._closing.close()


def _launch_viewer(model: MjModel, data: MjData) -> tuple[Handle, set[threading.Thread]]:
    """Return a viewer, and the threads that it has started."""
    from mujoco.viewer import launch_passive

    before = set(threading.enumerate())
    try:
        viewer = launch_passive(model, data, show_left_ui=False, show_right_ui=False)
    except RuntimeError as error:  # on macOS only
        raise BackendError(f"mujoco: {error}. Leave --gui out", kind="window-fails") from error
    return viewer, set(threading.enumerate()) - before


def _require_screen() -> None:
    """Raise BackendError if no window can open. Otherwise MuJoCo's thread would end, and `Window` wait forever."""
    import glfw

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if not glfw.init():
            raise BackendError(NO_SCREEN, kind="no-screen")
        glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
        window = glfw.create_window(1, 1, "", None, None)
        glfw.default_window_hints()
        if not window:
            raise BackendError("mujoco: this screen has no OpenGL. Leave --gui out", kind="no-screen")
        glfw.destroy_window(window)
