"""A wrapper of PyBullet: its import, a connection to a server, and its errors as errors of robotcore."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from robotcore.errors import BackendError, DeviceError, RobotcoreError
from robotcore.system import HAS_POSIX, IS_LINUX

ErrorFactory = Callable[[str], RobotcoreError]
"""Returns the error of robotcore for a text of Bullet."""

WINDOW_CLOSED = "If you closed the window of the simulation, run again and leave the window open"


class Bullet:
    """A connection to a Bullet server. Its attributes are PyBullet's functions and constants.

    As in ``pybullet_utils.bullet_client``, the server's id is passed to the functions. Their errors are BackendErrors,
    or DeviceErrors in a connection of `for_device`.
    """

    def __init__(self, library: ModuleType, client: int, make_error: ErrorFactory) -> None:
        self._library, self._client, self._make_error = library, client, make_error

    @classmethod
    def connect(cls, *, gui: bool) -> Bullet:
        """Start a new Bullet server in this process, with or without a window, and connect to it."""
        library = _import_pybullet()
        if gui:
            _require_screen()
        connect = _translate_errors(library.connect, library.error, _make_backend_error)
        client = connect(library.GUI if gui else library.DIRECT)
        return cls(library, client, _make_backend_error)

    def set_window_view(self, width_m: float) -> None:
        """Let the window show a world from above.

        width_m: the width of the world in metres, for the distance of the view.
        """
        self.configureDebugVisualizer(self.COV_ENABLE_GUI, 0)
        self.resetDebugVisualizerCamera(width_m, 0.0, -60.0, [0.0, 0.0, 0.0])

    def for_device(self, device: str) -> Bullet:
        """Return the same connection, whose functions raise DeviceError with the name of a device."""
        return Bullet(self._library, self._client, lambda text: DeviceError(device, text))

    def close(self) -> None:
        """End the server. Does nothing if the server has ended already, for example because its window was closed."""
        with redirect_stdout():
            if self._library.isConnected(self._client):
                self._library.disconnect(self._client)

    def __getattr__(self, name: str) -> Any:
        attribute = getattr(self._library, name)
        if not callable(attribute):
            return attribute

        function = _translate_errors(
            partial(attribute, physicsClientId=self._client), self._library.error, self._make_error
        )
        setattr(self, name, function)  # the next access finds it without this method
        return function


def _make_backend_error(text: str) -> BackendError:
    return BackendError(f"pybullet: {text}")


def _translate_errors(
    function: Callable[..., Any], bullet_error: type[Exception], make_error: ErrorFactory
) -> Callable[..., Any]:
    """Wrap a function so that it raises the error of ``make_error`` in place of ``bullet_error``."""

    def call(*args: Any, **options: Any) -> Any:
        try:
            return function(*args, **options)
        except bullet_error as error:
            raise make_error(f"{error} {WINDOW_CLOSED}") from error

    return call


def _import_pybullet() -> ModuleType:
    """Import PyBullet without the banner that it writes to standard error."""
    with Path(os.devnull).open("wb") as nowhere, _redirect(2, nowhere.fileno()):
        import pybullet

    module: ModuleType = pybullet
    return module


def _require_screen() -> None:
    """Raise BackendError if there is no screen for a window. Bullet would end the whole process."""
    if IS_LINUX and not os.environ.get("DISPLAY"):
        raise BackendError(
            "pybullet: there is no screen for a window. Leave --gui out, or set DISPLAY to a screen", kind="no-screen"
        )


def redirect_stdout() -> AbstractContextManager[None]:
    """Redirect standard output to standard error within a block. Bullet prints about its threads and windows."""
    return _redirect(1, 2)


@contextmanager
def _redirect(descriptor: int, target: int) -> Iterator[None]:
    """Redirect a file descriptor to another one within a block. Output of native code is redirected too."""
    _flush()
    saved = os.dup(descriptor)
    try:
        os.dup2(target, descriptor)
        yield
    finally:
        _flush()
        os.dup2(saved, descriptor)
        os.close(saved)


def _flush() -> None:
    sys.stdout.flush()
    sys.stderr.flush()
    if HAS_POSIX:
        ctypes.CDLL(None).fflush(None)
