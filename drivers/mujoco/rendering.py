"""Render the pictures of a pinhole camera in a MuJoCo simulation, with OpenGL and without a screen."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from drivers.mujoco.model.attributes import CAMERA_GROUPS, group_flags
from drivers.mujoco.model.builder import FAR_M, NEAR_M
from drivers.mujoco.model.world import visual_name
from drivers.mujoco.opengl import Context, open_context, select_for_mujoco
from robotcore.description import WorldDescription
from robotcore.optics import CameraView, Image
from robotcore.simulation.rigid_body import NoOpenGL, ObjectIds

if TYPE_CHECKING:
    from mujoco import MjData, MjModel, MjrContext, MjvGLCamera, MjvOption, MjvScene


_MAX_GEOMS = 10_000


class Renderer:
    """Renders the world and the sky of a simulation, without shadows, haze or smoothing.

    Several threads may use and close a renderer, but only one at a time.
    """

    def __init__(self, model: MjModel, data: MjData, world: WorldDescription) -> None:
        """Create an OpenGL context, and load the model into it.

        world: the world in the model.

        Raises NoOpenGL if no OpenGL library works without a screen.
        """
        from mujoco import MjvCamera

        self.things = {thing.name: model.geom(visual_name(thing.name)).id for thing in (*world.prisms, *world.targets)}
        """The ids of the visual geoms of the things, by the name of the thing."""
        self._model, self._data, self._sky = model, data, world.light.sky_colour
        self._scene, self._options, self._camera = _build_scene(model), _build_options(), MjvCamera()
        self._buffer = OffscreenBuffer(model)

    def picture(self, view: CameraView) -> Image:
        """Return the picture of a view, of shape (height, width, 3), in BGR."""
        rgb, depths = self._draw(view)
        image: Image = np.asarray(cv2.cvtColor(cv2.flip(rgb, 0), cv2.COLOR_RGB2BGR), dtype=np.uint8)
        is_sky = (cv2.flip(depths, 0) == 0.0).view(np.uint8)
        cv2.copyTo(
            _plain_image(self._sky[::-1], *depths.shape), is_sky, image
        )  # faster: MuJoCo's own sky takes as long as the rest of the picture
        return image

    def segmentation(self, view: CameraView) -> ObjectIds:
        """Return the id of the geom at each pixel of a view, of shape (height, width); -1 for the sky."""
        _set_flags(self._scene, "SEGMENT", "IDCOLOR", on=True)
        try:
            rgb, _ = self._draw(view)
        finally:
            _set_flags(self._scene, "SEGMENT", "IDCOLOR", on=False)
        codes = rgb[::-1].astype(np.int32) @ (1, 1 << 8, 1 << 16)  # the colour of a geom is its index plus 1
        geoms = (-1, *(geom.objid for geom in self._scene.geoms[: self._scene.ngeom]))
        return np.asarray(np.array(geoms, dtype=np.int32)[codes])

    def close(self) -> None:
        """Release OpenGL. Further calls do nothing."""
        self._buffer.close()

    def _draw(self, view: CameraView) -> tuple[Image, Depths]:
        from mujoco import mjtCatBit, mjv_updateScene

        scene, size = self._scene, view.intrinsics
        category = mjtCatBit.mjCAT_ALL.value
        mjv_updateScene(self._model, self._data, self._options, None, self._camera, category, scene)
        for camera in scene.camera:  # MuJoCo draws from the mean of a left and a right camera
            _place(camera, view)
        return self._buffer.draw(scene, size.width, size.height)


def _place(camera: MjvGLCamera, view: CameraView) -> None:
    _, down, forward = view.rotation
    top = NEAR_M * view.intrinsics.height / 2 / view.intrinsics.focal_length
    camera.pos, camera.forward, camera.up = view.eye, forward, -down
    camera.frustum_center, camera.frustum_bottom, camera.frustum_top = 0.0, -top, top
    camera.frustum_near, camera.frustum_far = NEAR_M, FAR_M


def _build_scene(model: MjModel) -> MjvScene:
    """Return a scene without shadows, reflections, haze and MuJoCo's own sky."""
    from mujoco import MjvScene

    scene = MjvScene(model, _MAX_GEOMS)
    _set_flags(scene, "SHADOW", "REFLECTION", "HAZE", "SKYBOX", on=False)
    return scene


def _set_flags(scene: MjvScene, *names: str, on: bool) -> None:
    from mujoco import mjtRndFlag

    for name in names:
        scene.flags[getattr(mjtRndFlag, f"mjRND_{name}")] = on


def _build_options() -> MjvOption:
    from mujoco import MjvOption

    options = MjvOption()
    options.geomgroup[:] = group_flags(CAMERA_GROUPS)
    return options


@lru_cache(maxsize=8)
def _plain_image(colour: tuple[int, ...], height: int, width: int) -> Image:
    return np.full((height, width, 3), colour, dtype=np.uint8)


Depths = NDArray[np.float32]

_TEXTURE_2D, _MAG_FILTER, _MIN_FILTER, _NEAREST = 0x0DE1, 0x2800, 0x2801, 0x2600
_CLAMP_VERTEX_COLOR, _FALSE = 0x891A, 0


class OffscreenBuffer:
    """Draws scenes of a model into memory. The constructor and `draw` raise NoOpenGL if OpenGL fails.

    Several threads may use and close a buffer, but only one at a time.
    """

    def __init__(self, model: MjModel) -> None:
        self._context, self._is_closed = open_context(), False
        try:
            self._drawing = _upload_model(model, self._context)
        except BaseException:
            self._context.close()
            raise

    def draw(self, scene: MjvScene, width: int, height: int) -> tuple[Image, Depths]:
        """Return the picture of a scene in RGB, (height, width, 3), and its depths, (height, width).

        The first row is the bottom of the picture. The depth of a nearer point is greater. The depth of the sky is 0.
        """
        from mujoco import MjrRect, mjr_readPixels, mjr_render

        rgb, depths = np.empty((height, width, 3), np.uint8), np.empty((height, width), np.float32)
        whole = MjrRect(0, 0, width, height)
        with self._context.current():
            _grow_buffer(self._drawing, width, height)
            mjr_render(whole, scene, self._drawing)
            mjr_readPixels(rgb, depths, whole, self._drawing)
        return rgb, depths

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
        drawing.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
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
