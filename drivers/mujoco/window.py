"""MuJoCo's window, which shows a running simulation."""

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
"""The view of a new window: from the south, down on the middle of the world. The distance is relative to the world's
width."""

FRAME_S = 0.04
"""The least simulated time between two updates of the window, in seconds. An update takes longer than many steps."""

CLOSING_S = 5.0
"""The time limit for the end of the window's thread, in seconds."""

WINDOW_LOCK = threading.Lock()
"""A lock that the open window holds. Each window has its own thread, and GLFW crashes if two threads call it."""


class Window:
    """A window that shows a copy of the robot and the world. The user's actions in the window do not change the run."""

    def __init__(self, model: MjModel, data: MjData, width_m: float) -> None:
        """Open the window.

        width_m: the width of the world in metres, for the distance of the view.

        Raises BackendError if the window cannot be opened, or if another window is open.
        """
        self._model, self._data, self._shown = copy(model), data, copy(data)
        self._due_s = 0.0
        if not WINDOW_LOCK.acquire(blocking=False):
            raise BackendError(
                "mujoco: another robot has a window already. Close that robot first, or leave --gui out",
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
        """Update the window to the current state, after `FRAME_S` of simulated time.

        Raises BackendError if the user has closed the window.
        """
        from mujoco import mj_copyData

        if not self._viewer.is_running():
            raise BackendError(
                "mujoco: the window was closed. Run again, and leave the window open", kind="window-closed"
            )
        if self._data.time >= self._due_s:
            self._due_s = self._data.time + FRAME_S
            mj_copyData(self._shown, self._model, self._data)
            self._viewer.sync()

    def close(self) -> None:
        """Close the window, and wait for its thread. Further calls do nothing."""
        self._viewer.close()
        for thread in self._threads:
            thread.join(CLOSING_S)
        self._closing.close()


def _launch_viewer(model: MjModel, data: MjData) -> tuple[Handle, set[threading.Thread]]:
    from mujoco.viewer import launch_passive

    before = set(threading.enumerate())
    try:
        viewer = launch_passive(model, data, show_left_ui=False, show_right_ui=False)
    except RuntimeError as error:  # on macOS only
        raise BackendError(f"mujoco: {error}. Leave --gui out", kind="window-fails") from error
    return viewer, set(threading.enumerate()) - before


def _require_screen() -> None:
    """Raise BackendError if no window can be opened. Otherwise MuJoCo's thread would end, and `Window` would hang."""
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
