"""Wraps PyBullet: its import, one connection, and its errors as errors of robotcore."""

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

Failure = Callable[[str], RobotcoreError]

WINDOW_CLOSED = "If its window was closed, run again and leave it open"


class Bullet:
    """One connection. Bullet's functions and constants are its attributes, as in ``pybullet_utils.bullet_client``.

    The functions raise BackendError. On the result of `for_device` they raise DeviceError.
    """

    def __init__(self, library: ModuleType, client: int, failure: Failure) -> None:
        self._library, self._client, self._failure = library, client, failure

    @classmethod
    def connect(cls, *, gui: bool) -> Bullet:
        """Start a new server in this process, with or without a window."""
        library = _import_pybullet()
        if gui:
            _require_screen()
        connect = _translate_errors(library.connect, library.error, _backend_failure)
        client = connect(library.GUI if gui else library.DIRECT)
        return cls(library, client, _backend_failure)

    def show(self, breadth: float) -> None:
        """Point the window's camera down at a world of this breadth in metres."""
        self.configureDebugVisualizer(self.COV_ENABLE_GUI, 0)
        self.resetDebugVisualizerCamera(breadth, 0.0, -60.0, [0.0, 0.0, 0.0])

    def for_device(self, device: str) -> Bullet:
        """Return the same connection with errors that name a device."""
        return Bullet(self._library, self._client, lambda fault: DeviceError(device, fault))

    def close(self) -> None:
        """End the server. It may have ended already, for example after its window was closed."""
        with redirect_stdout():
            if self._library.isConnected(self._client):
                self._library.disconnect(self._client)

    def __getattr__(self, name: str) -> Any:
        attribute = getattr(self._library, name)
        if not callable(attribute):
            return attribute

        return _translate_errors(partial(attribute, physicsClientId=self._client), self._library.error, self._failure)


def _backend_failure(fault: str) -> BackendError:
    return BackendError(f"pybullet: {fault}")


def _translate_errors(function: Callable[..., Any], fault: type[Exception], failure: Failure) -> Callable[..., Any]:
    """Return the function with the exception ``fault`` replaced by the result of ``failure``."""

    def call(*args: Any, **options: Any) -> Any:
        try:
            return function(*args, **options)
        except fault as error:
            raise failure(f"{error} {WINDOW_CLOSED}") from error

    return call


def _import_pybullet() -> ModuleType:
    """Import PyBullet without the banner that it writes to standard error."""
    with Path(os.devnull).open("w") as nowhere, _redirect(2, nowhere.fileno()):
        import pybullet

    module: ModuleType = pybullet
    return module


def _require_screen() -> None:
    """Raise BackendError if no window can open. Bullet would end the whole process."""
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        raise BackendError(
            "pybullet: there is no screen for a window. Leave --gui out, or set DISPLAY to a screen", kind="no-screen"
        )


def redirect_stdout() -> AbstractContextManager[None]:
    """Send Bullet's prints about threads and windows to standard error, not to standard output."""
    return _redirect(1, 2)


@contextmanager
def _redirect(descriptor: int, target: int) -> Iterator[None]:
    """Redirect a file descriptor to another one, for native code too."""
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
    """Flush Python's buffers and, except on Windows, those of the C library."""
    sys.stdout.flush()
    sys.stderr.flush()
    if sys.platform != "win32":
        ctypes.CDLL(None).fflush(None)
