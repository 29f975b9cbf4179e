"""Render the pictures of a pinhole camera in a MuJoCo simulation, with OpenGL and without a screen."""

from __future__ import annotations

from copy import copy
from functools import lru_cache
from typing import TYPE_CHECKING

import cv2
import numpy as np

from drivers.mujoco.model import build, compile_model
from drivers.mujoco.model.attributes import CAMERA_GROUPS, RenderGroup, group_flags
from drivers.mujoco.model.builder import FAR_M, NEAR_M
from drivers.mujoco.model.world import visual_name
from drivers.mujoco.offscreen_buffer import OffscreenBuffer, Pixels
from robotcore.description import WorldDescription
from robotcore.optics import CameraView, Image, Intrinsics
from robotcore.simulation.rigid_body import Array, ObjectIds

if TYPE_CHECKING:
    from mujoco import MjData, MjModel, MjvGLCamera, MjvOption, MjvScene


_MAX_GEOMS = 10_000

ROUNDING_M = 0.01
"""The length by which the bounding sphere of a geom is greater than in the model. MuJoCo draws in single precision."""


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
        self._data, self._sky = data, world.light.sky_colour
        self._model = copy(model)
        self._visible = VisibleGeoms(self._model, data)
        self._scene, self._options, self._camera = _build_scene(model), _build_options(), MjvCamera()
        self._buffer = OffscreenBuffer(model)

    def picture(self, view: CameraView) -> Image:
        """Return the picture of a view, of shape (height, width, 3), in BGR."""
        rgba = self._draw(view)
        bgr = cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGR)
        is_sky = (rgba.view(np.uint32)[:, :, 0] == 0).view(np.uint8)
        # This is faster than MuJoCo's own sky, which takes as long as the rest of the picture.
        cv2.copyTo(_plain_image(self._sky[::-1], *is_sky.shape), is_sky, bgr)
        return np.asarray(cv2.flip(bgr, 0), dtype=np.uint8)

    def segmentation(self, view: CameraView) -> ObjectIds:
        """Return the id of the geom at each pixel of a view, of shape (height, width); -1 for the sky."""
        _set_flags(self._scene, "SEGMENT", "IDCOLOR", on=True)
        try:
            rgba = self._draw(view)
        finally:
            _set_flags(self._scene, "SEGMENT", "IDCOLOR", on=False)
        codes = rgba[::-1, :, :3].astype(np.int32) @ (1, 1 << 8, 1 << 16)  # the colour of a geom is its index plus 1
        geoms = (-1, *(geom.objid for geom in self._scene.geoms[: self._scene.ngeom]))
        return np.asarray(np.array(geoms, dtype=np.int32)[codes])

    def close(self) -> None:
        """Release OpenGL. Further calls do nothing."""
        self._buffer.close()

    def _draw(self, view: CameraView) -> Pixels:
        from mujoco import mjtCatBit, mjv_updateScene

        scene, size = self._scene, view.intrinsics
        self._visible.select(view)
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


def build_renderer(world: WorldDescription) -> Renderer:
    """Return a renderer of a world without a robot. No picture shows the robot, so the pictures are the same."""
    from mujoco import MjData, mj_forward

    model = compile_model(build(None, world))
    data = MjData(model)
    mj_forward(model, data)
    return Renderer(model, data, world)


class VisibleGeoms:
    """Leaves the geoms out of a model's pictures that are completely outside of the view of the camera.

    MuJoCo would compute each of their triangles.
    """

    def __init__(self, model: MjModel, data: MjData) -> None:
        """Find the geoms that the cameras show. They do not move.

        model: the model, in which `select` changes the groups of these geoms.
        data: the state of the model.
        """
        self._all_groups = model.geom_group
        self._numbers = np.flatnonzero(np.isin(self._all_groups, list(CAMERA_GROUPS)))
        self._groups = self._all_groups[self._numbers]
        self._centres = data.geom_xpos[self._numbers].copy()
        self._radii = model.geom_rbound[self._numbers] + ROUNDING_M

    def select(self, view: CameraView) -> None:
        """Let the next scene of the model have only those geoms whose bounding spheres reach into a view."""
        gaps = _compute_sides(view.intrinsics) @ view.to_camera(self._centres).T
        is_hidden = (gaps > self._radii).any(axis=0)
        self._all_groups[self._numbers] = np.where(is_hidden, RenderGroup.ROBOT, self._groups)


@lru_cache(maxsize=8)
def _compute_sides(lens: Intrinsics) -> Array:
    """Return the outward unit normals of the planes through the camera and the edges of its picture, (4, 3)."""
    across, down, ahead = lens.width / 2, lens.height / 2, lens.focal_length
    normals = np.array(((ahead, 0.0, -across), (-ahead, 0.0, -across), (0.0, ahead, -down), (0.0, -ahead, -down)))
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))
