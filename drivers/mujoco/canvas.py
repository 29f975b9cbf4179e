"""What MuJoCo draws on: memory of OpenGL's, without a screen."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivers.mujoco.opengl import Context, NoOpenGL, named_to_mujoco, open_context
from robotcore.hal.devices import Image

if TYPE_CHECKING:
    from mujoco import MjModel, MjrContext, MjvScene

Depths = NDArray[np.float32]

_TEXTURE_2D, _MAG_FILTER, _MIN_FILTER, _NEAREST = 0x0DE1, 0x2800, 0x2801, 0x2600
_CLAMP_VERTEX_COLOR, _FALSE = 0x891A, 0


class Canvas:
    """Holds what a model looks like. Raises NoOpenGL, when it is made and when it is drawn on.

    Any thread may use it, and close it, one at a time.
    """

    def __init__(self, model: MjModel) -> None:
        self._context, self._is_closed = open_context(), False
        try:
            self._drawing = _drawing(model, self._context)
        except BaseException:
            self._context.close()
            raise

    def draw(self, scene: MjvScene, width: int, height: int) -> tuple[Image, Depths]:
        """Return a scene, from the bottom row up: RGB, and depths, greater where nearer and 0 where nothing is."""
        from mujoco import MjrRect, mjr_readPixels, mjr_render

        rgb, depths = np.empty((height, width, 3), np.uint8), np.empty((height, width), np.float32)
        whole = MjrRect(0, 0, width, height)
        with self._context.current():
            _make_room(self._drawing, width, height)
            mjr_render(whole, scene, self._drawing)
            mjr_readPixels(rgb, depths, whole, self._drawing)
        return rgb, depths

    def close(self) -> None:
        """Let all of OpenGL go: what is left open complains when the process ends. May be called again."""
        if not self._is_closed:
            self._is_closed = True
            with self._context.current():
                self._drawing.free()
            self._context.close()


def _drawing(model: MjModel, context: Context) -> MjrContext:
    """Hand everything that a model shows over to OpenGL."""
    import mujoco

    model.vis.global_.offwidth = model.vis.global_.offheight = 1  # it grows to what is drawn: all of it is cleared
    with context.current(), named_to_mujoco(context):
        try:
            drawing = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50.value)
        except mujoco.FatalError as error:
            raise context.refusal(f"MuJoCo cannot draw by {context.name}: {error}") from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, drawing)
        drawing.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        _sharpen(drawing, context)
        _let_glare(context)
    return drawing


def _make_room(drawing: MjrContext, width: int, height: int) -> None:
    from mujoco import mjr_resizeOffscreen

    if width > drawing.offWidth or height > drawing.offHeight:
        mjr_resizeOffscreen(max(width, drawing.offWidth), max(height, drawing.offHeight), drawing)


def _sharpen(drawing: MjrContext, context: Context) -> None:
    """Let each pixel show the one texel that it hits, as the other simulators do; MuJoCo takes a mean of several."""
    from mujoco import mjtTexture

    bind = _function(context, "glBindTexture", ctypes.c_uint, ctypes.c_uint)
    let = _function(context, "glTexParameteri", ctypes.c_uint, ctypes.c_uint, ctypes.c_int)
    for number in range(drawing.ntexture):
        if drawing.textureType[number] == mjtTexture.mjTEXTURE_2D:
            bind(_TEXTURE_2D, drawing.texture[number])
            let(_TEXTURE_2D, _MAG_FILTER, _NEAREST)
            let(_TEXTURE_2D, _MIN_FILTER, _NEAREST)


def _let_glare(context: Context) -> None:
    """Let a texture darken what is brighter than white, as in the other simulators; OpenGL makes it white before."""
    clamp = _function(context, "glClampColor", ctypes.c_uint, ctypes.c_uint)
    clamp(_CLAMP_VERTEX_COLOR, _FALSE)


def _function(context: Context, name: str, *arguments: type) -> Callable[..., None]:
    if not (address := context.address_of(name)):
        raise NoOpenGL(f"{context.name} does not know {name}")
    return ctypes.CFUNCTYPE(None, *arguments)(address)
