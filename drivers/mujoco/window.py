"""MuJoCo's own window on a simulation."""

from __future__ import annotations

import threading
import warnings
from copy import copy
from typing import TYPE_CHECKING

from robotcore.errors import BackendError

if TYPE_CHECKING:
    from mujoco import MjData, MjModel

NO_SCREEN = "mujoco: there is no screen to open a window on. Leave --gui out, or set DISPLAY"

AZIMUTH_DEG, ELEVATION_DEG, AWAY = 90.0, -60.0, 1.2
"""From where it looks at first: from the world's own below, down on its middle; so many times its breadth away."""

CLOSING_S = 5.0


class Window:
    """Shows a copy of the robot and the world, ``breadth`` metres across: no hand in it changes how a run goes.

    Raises BackendError where no window can open.
    """

    def __init__(self, model: MjModel, data: MjData, breadth: float) -> None:
        _require_screen()
        from mujoco.viewer import launch_passive

        self._data, self._shown = data, copy(data)
        self._model = copy(model)
        threads = set(threading.enumerate())
        try:
            self._viewer = launch_passive(self._model, self._shown, show_left_ui=False, show_right_ui=False)
        except RuntimeError as error:  # on macOS only
            raise BackendError(f"mujoco: {error}. Leave --gui out") from error
        self._threads = set(threading.enumerate()) - threads
        with self._viewer.lock():
            camera = self._viewer.cam
            camera.lookat[:], camera.distance = 0.0, AWAY * breadth
            camera.azimuth, camera.elevation = AZIMUTH_DEG, ELEVATION_DEG

    def show(self) -> None:
        """Show how everything is now; raises BackendError once the window was closed."""
        from mujoco import mj_copyData

        if not self._viewer.is_running():
            raise BackendError("mujoco: its window was closed. Run again and leave it open")
        mj_copyData(self._shown, self._model, self._data)
        self._viewer.sync()

    def close(self) -> None:
        """Close the window, and wait until it has gone. May be called again."""
        self._viewer.close()
        for thread in self._threads:
            thread.join(CLOSING_S)


def _require_screen() -> None:
    """Raise BackendError where a window cannot open: MuJoCo's thread would die, and whoever asked wait for ever."""
    import glfw

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if not glfw.init():
            raise BackendError(NO_SCREEN)
        glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
        window = glfw.create_window(1, 1, "", None, None)
        glfw.default_window_hints()
        if not window:
            raise BackendError("mujoco: this screen shows no OpenGL. Leave --gui out")
        glfw.destroy_window(window)
