"""OpenGL contexts that need no screen: EGL, on a graphics card or in software, and OSMesa."""

from __future__ import annotations

import ctypes
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from ctypes import POINTER, byref, c_char_p, c_int, c_uint, c_void_p
from typing import Any, ClassVar

from robotcore.simulation.rigid_body import NoOpenGL


@contextmanager
def set_variable(variable: str, value: str) -> Iterator[None]:
    """Set an environment variable within a block."""
    before = os.environ.get(variable)
    os.environ[variable] = value
    try:
        yield
    finally:
        if before is None:
            del os.environ[variable]
        else:
            os.environ[variable] = before


class Context(ABC):
    """An OpenGL context that draws into memory. The constructor raises NoOpenGL if the context cannot be created.

    A thread makes the context current only while it draws. So threads can take turns.
    """

    name: ClassVar[str]
    """The value of the environment variable MUJOCO_GL that selects this class of context."""

    packages: ClassVar[str]
    """The Debian packages that contain the library of this context, separated by spaces."""

    @classmethod
    def build_error(cls, problem: str) -> NoOpenGL:
        """Return the error for a context that cannot draw, maybe because of another OpenGL library in the process."""
        return NoOpenGL(f"{problem}. If your program also opens a window or another renderer, set MUJOCO_GL={cls.name}")

    @abstractmethod
    def current(self) -> AbstractContextManager[None]:
        """Make the context current for this thread within a block, and restore the previous context after it.

        Raises NoOpenGL if the context cannot be made current.
        """

    @abstractmethod
    def address_of(self, function: str) -> int | None:
        """Return the address of an OpenGL function; None or 0 if the library does not have it."""

    @abstractmethod
    def close(self) -> None:
        """Release the context. Further calls do nothing."""


def load_library(names: Sequence[str]) -> ctypes.CDLL:
    """Load the first installed library of ``names``, and return it. MuJoCo's C library finds its functions too.

    Raises NoOpenGL if no library is installed.
    """
    for name in names:
        try:
            return ctypes.CDLL(name, mode=ctypes.RTLD_GLOBAL)
        except OSError:  # noqa: PERF203  the next library may be installed
            continue
    raise NoOpenGL(f"{names[0]} is not installed")


EGL_LIBRARIES = ("libEGL.so.1",)

_OPENGL_API = 0x30A2
_PLATFORM_DEVICE = 0x313F
_SURFACE_TYPE, _PBUFFER_BIT = 0x3033, 0x0001
_RENDERABLE_TYPE, _OPENGL_BIT = 0x3040, 0x0008
_NONE = 0x3038
_DRAW, _READ = 0x3059, 0x305A
_MAX_DEVICES = 16


class EglContext(Context):
    """An EGL context on the first device that works, without a surface. MuJoCo draws into its own buffers."""

    name = "egl"
    packages = "libegl1 libgl1-mesa-dri"

    def __init__(self) -> None:
        self._egl = egl = _declare_egl_types(load_library(EGL_LIBRARIES))
        with set_variable("EGL_LOG_LEVEL", "fatal"):  # a NoOpenGL reports the missing parts
            self._display = _open_display(egl)
        egl.eglBindAPI(_OPENGL_API)
        self._context = egl.eglCreateContext(self._display, _choose_config(egl, self._display), None, None)
        if not self._context:
            raise NoOpenGL(f"EGL cannot create a context, error {egl.eglGetError():#x}")

    @contextmanager
    def current(self) -> Iterator[None]:
        egl = self._egl
        before = (egl.eglGetCurrentSurface(_DRAW), egl.eglGetCurrentSurface(_READ), egl.eglGetCurrentContext())
        display = egl.eglGetCurrentDisplay() or self._display
        if not egl.eglMakeCurrent(self._display, None, None, self._context):
            raise self.build_error(f"EGL does not let this thread draw, error {egl.eglGetError():#x}")
        try:
            yield
        finally:
            egl.eglMakeCurrent(display, *before)

    def address_of(self, function: str) -> int | None:
        address: int | None = self._egl.eglGetProcAddress(function.encode())
        return address

    def close(self) -> None:
        """Release the context. The display stays open, because all contexts of the process share it."""
        if self._context:
            self._egl.eglDestroyContext(self._display, self._context)
            self._context = None


def _declare_egl_types(egl: ctypes.CDLL) -> ctypes.CDLL:
    """Declare the pointer arguments of EGL's functions, which ctypes would otherwise cut to 32 bits."""
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


def _open_display(egl: ctypes.CDLL) -> int:
    query = _load_extension(egl, "eglQueryDevicesEXT", c_uint, c_int, POINTER(c_void_p), POINTER(c_int))
    display_of = _load_extension(egl, "eglGetPlatformDisplayEXT", c_void_p, c_uint, c_void_p, c_void_p)
    devices, count = (c_void_p * _MAX_DEVICES)(), c_int()
    query(_MAX_DEVICES, devices, byref(count))
    for device in devices[: count.value]:
        display: int | None = display_of(_PLATFORM_DEVICE, device, None)
        if display and egl.eglInitialize(display, None, None):
            return display
    raise NoOpenGL("libEGL.so.1 finds no driver, not even a software renderer")


def _load_extension(egl: ctypes.CDLL, name: str, result: type, *arguments: type) -> Callable[..., Any]:
    if not (address := egl.eglGetProcAddress(name.encode())):
        raise NoOpenGL(f"libEGL.so.1 has no function {name}")
    return ctypes.CFUNCTYPE(result, *arguments)(address)


def _choose_config(egl: ctypes.CDLL, display: int) -> c_void_p:
    wanted = (_SURFACE_TYPE, _PBUFFER_BIT, _RENDERABLE_TYPE, _OPENGL_BIT, _NONE)
    config, count = c_void_p(), c_int()
    egl.eglChooseConfig(display, (c_int * len(wanted))(*wanted), byref(config), 1, byref(count))
    if not count.value:
        raise NoOpenGL("EGL has no configuration that lets OpenGL draw into memory")
    return config


OSMESA_LIBRARIES = ("libOSMesa.so.8", "libOSMesa.so.6")

_RGBA, _UNSIGNED_BYTE = 0x1908, 0x1401
_DEPTH_BITS, _STENCIL_BITS = 24, 8


class OsmesaContext(Context):
    """An OSMesa context with a buffer of one pixel. MuJoCo draws into its own buffers."""

    name = "osmesa"
    packages = "libosmesa6"

    def __init__(self) -> None:
        self._osmesa = osmesa = _declare_osmesa_types(load_library(OSMESA_LIBRARIES))
        self._pixel = (ctypes.c_ubyte * 4)()
        self._context = osmesa.OSMesaCreateContextExt(_RGBA, _DEPTH_BITS, _STENCIL_BITS, 0, None)
        if not self._context:
            raise NoOpenGL("OSMesa cannot create a context")

    @contextmanager
    def current(self) -> Iterator[None]:
        """Make the context current for this thread within a block. After the block, no context is current."""
        if not self._osmesa.OSMesaMakeCurrent(self._context, self._pixel, _UNSIGNED_BYTE, 1, 1):
            raise self.build_error("OSMesa does not let this thread draw")
        try:
            yield
        finally:
            self._osmesa.OSMesaMakeCurrent(None, None, _UNSIGNED_BYTE, 0, 0)

    def address_of(self, function: str) -> int | None:
        address: int | None = self._osmesa.OSMesaGetProcAddress(function.encode())
        return address

    def close(self) -> None:
        if self._context:
            self._osmesa.OSMesaDestroyContext(self._context)
            self._context = None


def _declare_osmesa_types(osmesa: ctypes.CDLL) -> ctypes.CDLL:
    """Declare the pointer arguments of OSMesa's functions, which ctypes would otherwise cut to 32 bits."""
    osmesa.OSMesaCreateContextExt.restype = c_void_p
    osmesa.OSMesaMakeCurrent.argtypes = [c_void_p, c_void_p, c_uint, c_int, c_int]
    osmesa.OSMesaDestroyContext.restype = None
    osmesa.OSMesaDestroyContext.argtypes = [c_void_p]
    osmesa.OSMesaGetProcAddress.restype = c_void_p
    osmesa.OSMesaGetProcAddress.argtypes = [c_char_p]
    return osmesa


VARIABLE = "MUJOCO_GL"
"""The environment variable that selects the OpenGL library. MuJoCo's Python package and C library read it too."""

CONTEXTS: Mapping[str, type[Context]] = {context.name: context for context in (EglContext, OsmesaContext)}


_DISABLED = {"", "disable", "disabled", "off", "false", "0"}
"""The values of the variable with which MuJoCo's Python package loads no OpenGL library."""


def is_opengl_requested() -> bool:
    """Return whether MUJOCO_GL names an OpenGL library."""
    return _read_variable() not in _DISABLED


def _read_variable() -> str:
    return os.environ.get(VARIABLE, "").strip().lower()


def open_context() -> Context:
    """Create and return an OpenGL context that needs no screen.

    Tries EGL, then OSMesa. If the environment variable MUJOCO_GL names one of them, tries only this one. Raises
    NoOpenGL, with the command that installs a library, if no context can be created.
    """
    named = _read_variable()
    if named and named not in CONTEXTS:
        raise NoOpenGL(
            f"{VARIABLE} is {named!r}, which cannot draw without a window. "
            f"Unset it, or set it to {' or '.join(CONTEXTS)}"
        )
    contexts = (CONTEXTS[named],) if named else tuple(CONTEXTS.values())
    failures = []
    for context in contexts:
        try:
            return context()
        except NoOpenGL as failure:  # noqa: PERF203  the message has every failure
            failures.append(str(failure))
    problem = f"{VARIABLE} is {named!r}, which does not work" if named else "no OpenGL library works without a screen"
    remedy = f"On Debian: sudo apt install {', or '.join(context.packages for context in contexts)}"
    raise NoOpenGL(f"{problem}: {'; '.join(failures)}. {remedy}")


def select_for_mujoco(context: Context) -> AbstractContextManager[None]:
    """Set MUJOCO_GL within a block, so that MuJoCo's C library uses the same OpenGL library as the context.

    The C library loads its OpenGL functions once in a process.
    """
    return set_variable(VARIABLE, context.name)
