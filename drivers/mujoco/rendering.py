"""Pictures of a model as a pinhole camera sees it."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from drivers.mujoco.canvas import Canvas, Depths
from drivers.mujoco.model.building import FAR_M, NEAR_M
from drivers.mujoco.model.groups import SEEN, flags
from robotcore.hal.devices import Image
from robotcore.optics import View

if TYPE_CHECKING:
    from mujoco import MjData, MjModel, MjvGLCamera, MjvOption, MjvScene

Numbers = NDArray[np.int32]

_MOST_GEOMS = 10_000


class Renderer:
    """Draws what stands in a model's world, without shadows, haze or smoothing, and the ``sky``: red, green, blue.

    Raises NoOpenGL where it cannot. Any thread may use it, and close it, one at a time.
    """

    def __init__(self, model: MjModel, data: MjData, sky: tuple[int, int, int]) -> None:
        from mujoco import MjvCamera

        self._model, self._data, self._sky = model, data, sky
        self._scene, self._options, self._unmoved = _scene(model), _options(), MjvCamera()
        self._canvas = Canvas(model)

    def picture(self, view: View) -> Image:
        """Return what a camera would see, (height, width, 3), BGR."""
        rgb, depths = self._drawn(view)
        image: Image = np.asarray(cv2.cvtColor(cv2.flip(rgb, 0), cv2.COLOR_RGB2BGR), dtype=np.uint8)
        is_sky = (cv2.flip(depths, 0) == 0.0).view(np.uint8)
        cv2.copyTo(_plain(self._sky[::-1], *depths.shape), is_sky, image)  # its sky takes MuJoCo as long as all else
        return image

    def numbers(self, view: View) -> Numbers:
        """Return for each pixel, (height, width), the number of the geom that it shows; -1: sky."""
        _flag(self._scene, "SEGMENT", "IDCOLOR", on=True)
        try:
            rgb, _ = self._drawn(view)
        finally:
            _flag(self._scene, "SEGMENT", "IDCOLOR", on=False)
        inks = rgb[::-1].astype(np.int32) @ (1, 1 << 8, 1 << 16)  # each geom is drawn in one more than its place
        geoms = (-1, *(geom.objid for geom in self._scene.geoms[: self._scene.ngeom]))
        return np.asarray(np.array(geoms, dtype=np.int32)[inks])

    def close(self) -> None:
        """Let OpenGL go. May be called again."""
        self._canvas.close()

    def _drawn(self, view: View) -> tuple[Image, Depths]:
        from mujoco import mjtCatBit, mjv_updateScene

        scene, size = self._scene, view.intrinsics
        category = mjtCatBit.mjCAT_ALL.value
        mjv_updateScene(self._model, self._data, self._options, None, self._unmoved, category, scene)
        for eye in scene.camera:  # of a head with two, whose mean is drawn
            _place(eye, view)
        return self._canvas.draw(scene, size.width, size.height)


def _place(eye: MjvGLCamera, view: View) -> None:
    """Let one of MuJoCo's cameras be where the view's is, with its frustum: pixels are square, their centres count."""
    _, down, forward = view.rotation
    top = NEAR_M * view.intrinsics.height / 2 / view.intrinsics.focal_length
    eye.pos, eye.forward, eye.up = view.eye, forward, -down
    eye.frustum_center, eye.frustum_bottom, eye.frustum_top = 0.0, -top, top
    eye.frustum_near, eye.frustum_far = NEAR_M, FAR_M


def _scene(model: MjModel) -> MjvScene:
    """Return a scene that shows what stands where in the light, and no more."""
    from mujoco import MjvScene

    scene = MjvScene(model, _MOST_GEOMS)
    _flag(scene, "SHADOW", "REFLECTION", "HAZE", "SKYBOX", on=False)
    return scene


def _flag(scene: MjvScene, *names: str, on: bool) -> None:
    from mujoco import mjtRndFlag

    for name in names:
        scene.flags[getattr(mjtRndFlag, f"mjRND_{name}")] = on


def _options() -> MjvOption:
    from mujoco import MjvOption

    options = MjvOption()
    options.geomgroup[:] = flags(SEEN)
    return options


@lru_cache(maxsize=8)
def _plain(colour: tuple[int, ...], height: int, width: int) -> Image:
    """Return a picture of one BGR colour."""
    return np.full((height, width, 3), colour, dtype=np.uint8)
