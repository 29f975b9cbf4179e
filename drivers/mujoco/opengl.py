"""OpenGL without a screen: by EGL, on a graphics card or in software, or else by OSMesa."""

from __future__ import annotations

import ctypes
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from ctypes import POINTER, byref, c_char_p, c_int, c_uint, c_void_p
from typing import Any, ClassVar


@contextmanager
def set_variable(variable: str, value: str) -> Iterator[None]:
    """Let a variable have this value for a while."""
    before = os.environ.get(variable)
    os.environ[variable] = value
    try:
        yield
    finally:
        if before is None:
            del os.environ[variable]
        else:
            os.environ[variable] = before


class NoOpenGL(Exception):  # noqa: N818  the fact, which its catcher makes an error of
    """This way to OpenGL is not to be had on this machine; the message says what is missing."""


class Context(ABC):
    """OpenGL that draws into memory. A constructor raises NoOpenGL where there is none.

    Between two uses it belongs to no thread, so that any thread may have the next. ``name`` is what MuJoCo calls its
    kind, in the environment variable MUJOCO_GL; ``packages`` of Debian's bring it.
    """

    name: ClassVar[str]
    packages: ClassVar[str]

    @classmethod
    def refusal(cls, why: str) -> NoOpenGL:
        """Return why it does not draw, and what to do where it is not the only OpenGL of the program."""
        beside = f"Where the program has a window or a renderer of its own, set MUJOCO_GL={cls.name}"
        return NoOpenGL(f"{why}. {beside}")

    @abstractmethod
    def current(self) -> AbstractContextManager[None]:
        """Let this thread draw here; what it drew to before is given back to it. Raises NoOpenGL."""

    @abstractmethod
    def address_of(self, function: str) -> int | None:
        """Return where one of OpenGL's functions is."""

    @abstractmethod
    def close(self) -> None:
        """Let it go. May be called again."""


def load_library(names: Sequence[str]) -> ctypes.CDLL:
    """Return the first of these libraries that is there, all of whose functions MuJoCo finds too."""
    for name in names:
        try:
            return ctypes.CDLL(name, mode=ctypes.RTLD_GLOBAL)
        except OSError:  # noqa: PERF203  the next may be there
            continue
    raise NoOpenGL(f"{names[0]} is not installed")


EGL_LIBRARIES = ("libEGL.so.1",)

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
        self._egl = egl = _typed_egl(load_library(EGL_LIBRARIES))
        with set_variable("EGL_LOG_LEVEL", "fatal"):  # what it lacks is told of here
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


def _typed_egl(egl: ctypes.CDLL) -> ctypes.CDLL:
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


OSMESA_LIBRARIES = ("libOSMesa.so.8", "libOSMesa.so.6")

_RGBA, _UNSIGNED_BYTE = 0x1908, 0x1401
_DEPTH_BITS, _STENCIL_BITS = 24, 8


class OsmesaContext(Context):
    """A context with one pixel of its own: MuJoCo draws into buffers of its own."""

    name = "osmesa"
    packages = "libosmesa6"

    def __init__(self) -> None:
        self._osmesa = osmesa = _typed_osmesa(load_library(OSMESA_LIBRARIES))
        self._pixel = (ctypes.c_ubyte * 4)()
        self._context = osmesa.OSMesaCreateContextExt(_RGBA, _DEPTH_BITS, _STENCIL_BITS, 0, None)
        if not self._context:
            raise NoOpenGL("OSMesa makes no context")

    @contextmanager
    def current(self) -> Iterator[None]:
        """As told; OSMesa does not tell into whose memory the thread drew before, so that nothing is current then."""
        if not self._osmesa.OSMesaMakeCurrent(self._context, self._pixel, _UNSIGNED_BYTE, 1, 1):
            raise self.refusal("OSMesa does not let this thread draw")
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


def _typed_osmesa(osmesa: ctypes.CDLL) -> ctypes.CDLL:
    """Tell ctypes which of OSMesa's functions take and return pointers, which it would cut to half."""
    osmesa.OSMesaCreateContextExt.restype = c_void_p
    osmesa.OSMesaMakeCurrent.argtypes = [c_void_p, c_void_p, c_uint, c_int, c_int]
    osmesa.OSMesaDestroyContext.restype = None
    osmesa.OSMesaDestroyContext.argtypes = [c_void_p]
    osmesa.OSMesaGetProcAddress.restype = c_void_p
    osmesa.OSMesaGetProcAddress.argtypes = [c_char_p]
    return osmesa


VARIABLE = "MUJOCO_GL"
"""By which MuJoCo itself is told; MuJoCo's C library reads it too."""

CONTEXTS: Mapping[str, type[Context]] = {way.name: way for way in (EglContext, OsmesaContext)}


def open_context() -> Context:
    """Return OpenGL that needs no screen; raises NoOpenGL, with the remedy, where there is none.

    The user may name a way by the environment variable MUJOCO_GL; then no other is tried.
    """
    named = os.environ.get(VARIABLE, "").strip().lower()
    if named and named not in CONTEXTS:
        raise NoOpenGL(
            f"{VARIABLE} is {named!r}, which draws nothing without a window. "
            f"Unset it, or set it to {' or '.join(CONTEXTS)}"
        )
    ways = (CONTEXTS[named],) if named else tuple(CONTEXTS.values())
    failures = []
    for way in ways:
        try:
            return way()
        except NoOpenGL as failure:  # noqa: PERF203  every way that fails is to be told
            failures.append(str(failure))
    what = f"{VARIABLE} is {named!r}, which does not work" if named else "there is no OpenGL without a screen"
    remedy = f"On Debian: sudo apt install {', or '.join(way.packages for way in ways)}"
    raise NoOpenGL(f"{what}: {'; '.join(failures)}. {remedy}")


def announce_to_mujoco(context: Context) -> AbstractContextManager[None]:
    """Let MuJoCo's C library look for OpenGL's functions where this context has them, as it does once in a process."""
    return set_variable(VARIABLE, context.name)
