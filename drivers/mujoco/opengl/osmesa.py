"""OpenGL by OSMesa: in software, by a library that Mesa made up to version 25.0."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import c_char_p, c_int, c_uint, c_void_p

from drivers.mujoco.opengl.context import Context, NoOpenGL, loaded

LIBRARIES = ("libOSMesa.so.8", "libOSMesa.so.6")

_RGBA, _UNSIGNED_BYTE = 0x1908, 0x1401
_DEPTH_BITS, _STENCIL_BITS = 24, 8


class OsmesaContext(Context):
    """A context with one pixel of its own: MuJoCo draws into buffers of its own."""

    name = "osmesa"
    packages = "libosmesa6"

    def __init__(self) -> None:
        self._osmesa = osmesa = _typed(loaded(LIBRARIES))
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


def _typed(osmesa: ctypes.CDLL) -> ctypes.CDLL:
    """Tell ctypes which of OSMesa's functions take and return pointers, which it would cut to half."""
    osmesa.OSMesaCreateContextExt.restype = c_void_p
    osmesa.OSMesaMakeCurrent.argtypes = [c_void_p, c_void_p, c_uint, c_int, c_int]
    osmesa.OSMesaDestroyContext.restype = None
    osmesa.OSMesaDestroyContext.argtypes = [c_void_p]
    osmesa.OSMesaGetProcAddress.restype = c_void_p
    osmesa.OSMesaGetProcAddress.argtypes = [c_char_p]
    return osmesa
