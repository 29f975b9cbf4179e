"""An OpenGL framebuffer that draws MuJoCo's scenes into memory, with the textures as in the other simulators."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivers.mujoco.opengl import Context, open_context, select_for_mujoco
from robotcore.simulation.rigid_body import NoOpenGL

if TYPE_CHECKING:
    from mujoco import MjModel, MjrContext, MjvScene

Pixels = NDArray[np.uint8]
"""A picture as red, green, blue and alpha, (height, width, 4). The first row is the bottom of the picture.

All four parts of the sky are 0. The alpha of anything else is 255.
"""

_RGBA, _UNSIGNED_BYTE = 0x1908, 0x1401
_TEXTURE_2D, _MAG_FILTER, _MIN_FILTER, _NEAREST = 0x0DE1, 0x2800, 0x2801, 0x2600
_CLAMP_VERTEX_COLOR, _FALSE = 0x891A, 0


class OffscreenBuffer:
    """Draws scenes of a model into memory. The constructor and `draw` raise NoOpenGL if OpenGL fails.

    Several threads may use and close a buffer, but only one at a time.
    """

    def __init__(self, model: MjModel) -> None:
        self._context, self._is_closed = open_context(), False
        self._pixels: Pixels = np.empty((0, 0, 4), np.uint8)
        try:
            self._drawing = _upload_model(model, self._context)
            numbers = (ctypes.c_int,) * 4
            self._read_pixels = _load_function(
                self._context, "glReadPixels", *numbers, ctypes.c_uint, ctypes.c_uint, ctypes.c_void_p
            )
        except BaseException:
            self._context.close()
            raise

    def draw(self, scene: MjvScene, width: int, height: int) -> Pixels:
        """Return the picture of a scene. The next picture may have the same array."""
        from mujoco import MjrRect, mjr_render

        if self._pixels.shape[:2] != (height, width):
            self._pixels = np.empty((height, width, 4), np.uint8)
        with self._context.current():
            _grow_buffer(self._drawing, width, height)
            mjr_render(MjrRect(0, 0, width, height), scene, self._drawing)
            # `mjr_readPixels` takes eight times as long. It converts the pixels, and only depths would show the sky.
            self._read_pixels(0, 0, width, height, _RGBA, _UNSIGNED_BYTE, self._pixels.ctypes.data)
        return self._pixels

    def close(self) -> None:
        """Release OpenGL, which would otherwise print errors at the end of the process. Further calls do nothing."""
        if not self._is_closed:
            self._is_closed = True
            with self._context.current():
                self._drawing.free()
            self._context.close()


def _upload_model(model: MjModel, context: Context) -> MjrContext:
    import mujoco

    model.vis.global_.offwidth = model.vis.global_.offheight = (
        1  # MuJoCo clears the whole buffer, so it grows with the pictures
    )
    with context.current(), select_for_mujoco(context):
        try:
            drawing = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50.value)
        except mujoco.FatalError as error:
            raise context.build_error(f"MuJoCo cannot draw with {context.name}: {error}") from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, drawing)
        _disable_smoothing(drawing, context)
        _disable_clamping(context)
    return drawing


def _grow_buffer(drawing: MjrContext, width: int, height: int) -> None:
    from mujoco import mjr_resizeOffscreen

    if width > drawing.offWidth or height > drawing.offHeight:
        mjr_resizeOffscreen(max(width, drawing.offWidth), max(height, drawing.offHeight), drawing)


def _disable_smoothing(drawing: MjrContext, context: Context) -> None:
    """Turn off the smoothing of textures, so that a pixel shows one point of the texture as in the other simulators."""
    from mujoco import mjtTexture

    bind = _load_function(context, "glBindTexture", ctypes.c_uint, ctypes.c_uint)
    set_parameter = _load_function(context, "glTexParameteri", ctypes.c_uint, ctypes.c_uint, ctypes.c_int)
    for number in range(drawing.ntexture):
        if drawing.textureType[number] == mjtTexture.mjTEXTURE_2D:
            bind(_TEXTURE_2D, drawing.texture[number])
            set_parameter(_TEXTURE_2D, _MAG_FILTER, _NEAREST)
            set_parameter(_TEXTURE_2D, _MIN_FILTER, _NEAREST)


def _disable_clamping(context: Context) -> None:
    """Limit the brightness after the textures are applied, not before, as in the other simulators."""
    clamp = _load_function(context, "glClampColor", ctypes.c_uint, ctypes.c_uint)
    clamp(_CLAMP_VERTEX_COLOR, _FALSE)


def _load_function(context: Context, name: str, *arguments: type) -> Callable[..., None]:
    if not (address := context.address_of(name)):
        raise NoOpenGL(f"{context.name} has no function {name}")
    return ctypes.CFUNCTYPE(None, *arguments)(address)
