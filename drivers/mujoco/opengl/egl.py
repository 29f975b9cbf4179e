"""OpenGL by EGL: on a graphics card, or in software where there is none.

Khronos, EGL 1.5 and the extensions EGL_EXT_device_enumeration and EGL_EXT_platform_device. It is asked through ctypes:
PyOpenGL decides for a whole process, at its first import, by which way OpenGL is had.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from ctypes import POINTER, byref, c_char_p, c_int, c_uint, c_void_p
from typing import Any

from drivers.mujoco.opengl.context import Context, NoOpenGL, loaded
from drivers.mujoco.opengl.environment import told

LIBRARIES = ("libEGL.so.1",)

_OPENGL_API = 0x30A2
_PLATFORM_DEVICE = 0x313F
_SURFACE_TYPE, _PBUFFER_BIT = 0x3033, 0x0001
_RENDERABLE_TYPE, _OPENGL_BIT = 0x3040, 0x0008
_NONE = 0x3038
_DRAW, _READ = 0x3059, 0x305A
_MOST_DEVICES = 16


class EglContext(Context):
    """A context on the first device that works; no surface is needed, MuJoCo draws into buffers of its own."""

    name = "egl"
    packages = "libegl1 libgl1-mesa-dri"

    def __init__(self) -> None:
        self._egl = egl = _typed(loaded(LIBRARIES))
        with told("EGL_LOG_LEVEL", "fatal"):  # what it lacks is told of here
            self._display = _display(egl)
        egl.eglBindAPI(_OPENGL_API)
        self._context = egl.eglCreateContext(self._display, _config(egl, self._display), None, None)
        if not self._context:
            raise NoOpenGL(f"EGL makes no context, error {egl.eglGetError():#x}")

    @contextmanager
    def current(self) -> Iterator[None]:
        egl = self._egl
        before = (egl.eglGetCurrentSurface(_DRAW), egl.eglGetCurrentSurface(_READ), egl.eglGetCurrentContext())
        display = egl.eglGetCurrentDisplay() or self._display
        if not egl.eglMakeCurrent(self._display, None, None, self._context):
            raise self.refusal(f"EGL does not let this thread draw, error {egl.eglGetError():#x}")
        try:
            yield
        finally:
            egl.eglMakeCurrent(display, *before)

    def address_of(self, function: str) -> int | None:
        address: int | None = self._egl.eglGetProcAddress(function.encode())
        return address

    def close(self) -> None:
        """Let the context go. The display stays: whoever else draws in this process has the same one."""
        if self._context:
            self._egl.eglDestroyContext(self._display, self._context)
            self._context = None


def _typed(egl: ctypes.CDLL) -> ctypes.CDLL:
    """Tell ctypes which of EGL's functions take and return pointers, which it would cut to half."""
    pointer = c_void_p
    types: dict[str, tuple[object, list[object]]] = {
        "eglGetProcAddress": (pointer, [c_char_p]),
        "eglInitialize": (c_uint, [pointer, pointer, pointer]),
        "eglChooseConfig": (c_uint, [pointer, pointer, pointer, c_int, pointer]),
        "eglCreateContext": (pointer, [pointer, pointer, pointer, pointer]),
        "eglDestroyContext": (c_uint, [pointer, pointer]),
        "eglMakeCurrent": (c_uint, [pointer, pointer, pointer, pointer]),
        "eglGetCurrentContext": (pointer, []),
        "eglGetCurrentDisplay": (pointer, []),
        "eglGetCurrentSurface": (pointer, [c_int]),
    }
    for name, (result, arguments) in types.items():
        function = getattr(egl, name)
        function.restype, function.argtypes = result, arguments
    return egl


def _display(egl: ctypes.CDLL) -> int:
    """Return the display of the first device that can be initialised."""
    query = _extension(egl, "eglQueryDevicesEXT", c_uint, c_int, POINTER(c_void_p), POINTER(c_int))
    display_of = _extension(egl, "eglGetPlatformDisplayEXT", c_void_p, c_uint, c_void_p, c_void_p)
    devices, count = (c_void_p * _MOST_DEVICES)(), c_int()
    query(_MOST_DEVICES, devices, byref(count))
    for device in devices[: count.value]:
        display: int | None = display_of(_PLATFORM_DEVICE, device, None)
        if display and egl.eglInitialize(display, None, None):
            return display
    raise NoOpenGL("libEGL.so.1 finds no driver, not even one in software")


def _extension(egl: ctypes.CDLL, name: str, result: type, *arguments: type) -> Callable[..., Any]:
    if not (address := egl.eglGetProcAddress(name.encode())):
        raise NoOpenGL(f"libEGL.so.1 does not know {name}")
    return ctypes.CFUNCTYPE(result, *arguments)(address)


def _config(egl: ctypes.CDLL, display: int) -> c_void_p:
    """Return any configuration that draws by OpenGL into memory."""
    wanted = (_SURFACE_TYPE, _PBUFFER_BIT, _RENDERABLE_TYPE, _OPENGL_BIT, _NONE)
    config, count = c_void_p(), c_int()
    egl.eglChooseConfig(display, (c_int * len(wanted))(*wanted), byref(config), 1, byref(count))
    if not count.value:
        raise NoOpenGL("EGL has no OpenGL that draws into memory")
    return config
