"""The cameras of a robot whose body a physics engine moves, and the choice of their renderer."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property, partial
from typing import Literal

import numpy as np

from robotcore.description import StrictModel, WorldDescription
from robotcore.errors import DeviceError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.simulation_state import SimulationState
from robotcore.kinds.camera import CameraDescription
from robotcore.optics import CameraView
from robotcore.simulation.painter import Painter
from robotcore.simulation.render_worker import PictureQueue, RenderWorker, has_free_core
from robotcore.simulation.rigid_body import BodyCamera, NoOpenGL, ObjectIds, Renderer, Transform

ROUNDING = 1e-6
"""A latency counts as a tick if it is shorter by at most this part of a tick."""


MAX_PICTURES = 32
"""The greatest number of pictures of a camera in the memory of the process that renders them."""


class CameraOptions(StrictModel):
    """The options of a backend whose engine has a renderer."""

    camera: Literal["rendered", "painted"] | None = None
    """Whether the engine renders the pictures, or robotcore paints them. Painting needs no OpenGL.

    None: the engine renders them. If it finds no OpenGL, they are painted, and the run has a note.
    """


def needs_sheet(setup: Setup, choice: str | None) -> bool:
    """Return whether an engine needs the sheet of `draw_floor_sheet`: for its window, or to render pictures.

    choice: `CameraOptions.camera`. Drawing a sheet takes up to 1 s.
    """
    has_camera = any(camera.name in setup.devices for camera in setup.robot.all_of("camera"))
    return setup.gui or (has_camera and choice != "painted")


class PaintedRenderer:
    """Paints the pictures of a world. The robot is not in them, as in the pictures of the engines."""

    def __init__(self, world: WorldDescription) -> None:
        self._painter = Painter(world)
        self.things = {name: label for label, name in enumerate(self._painter.things, start=1)}
        self.picture = self._painter.picture

    def segmentation(self, view: CameraView) -> ObjectIds:
        """Return the id of the thing at each pixel of a view, (height, width); 0 for the floor, -1 for the sky."""
        i, (right, down, forward) = view.intrinsics, view.rotation[:, 2]
        u, v = np.arange(i.width) - i.cx, np.arange(i.height)[:, None] - i.cy
        is_sky = u * right + v * down + i.focal_length * forward >= 0
        labels = self._painter.labels(view).astype(np.int32)
        return np.where(is_sky & (labels == 0), np.int32(-1), labels)


class CameraSet:
    """Opens the cameras of a robot, with the renderer that the user chose.

    choice: `CameraOptions.camera`.
    state: the state of the simulation.
    notes: the sentences about the renderer, for the user of a run.
    """

    def __init__(self, choice: str | None, state: SimulationState) -> None:
        self._choice, self._state = choice, state
        self._worker: RenderWorker | None = None
        self.notes: list[str] = []

    def open(
        self,
        description: CameraDescription,
        transform: Transform,
        open_renderer: Callable[[], Renderer],
        build_renderer: Callable[[], Renderer] | None,
    ) -> BodyCamera:
        """Open a camera. Raises DeviceError if the user chose the engine's renderer, and it finds no OpenGL.

        transform: returns the pose of the robot's frame.
        open_renderer: opens the engine's renderer. It raises NoOpenGL if it finds no OpenGL.
        build_renderer: builds a renderer of the same pictures in another process. `pickle` must be able to send it.
            None: only this process can render them.
        """
        renderer, state = self._open_renderer(description, open_renderer), self._state
        camera = BodyCamera(description, state.clock, transform, state.joints.locate, renderer, state.seed)
        if isinstance(renderer, PaintedRenderer):
            build_renderer = partial(PaintedRenderer, state.world)
        if build_renderer and isinstance(state.clock, SteppedClock):
            self._render_ahead(description, camera, build_renderer, state.clock.rate_hz)
        return camera

    def close(self) -> None:
        """End the process that renders pictures, if there is one. Further calls do nothing."""
        if self._worker:
            self._worker.close()

    def _render_ahead(
        self,
        description: CameraDescription,
        camera: BodyCamera,
        build_renderer: Callable[[], Renderer],
        tick_hz: float,
    ) -> None:
        """Let another process render the pictures of a camera, if their latency is a tick or more.

        An app reads at most one picture in a tick. So this process renders those of a faster camera.
        """
        rate_hz = description.rate_hz or tick_hz
        pictures = math.ceil(description.latency_s * rate_hz) + 2
        is_late, is_fast = description.latency_s * tick_hz >= 1 - ROUNDING, rate_hz > tick_hz
        if is_late and not is_fast and pictures <= MAX_PICTURES and has_free_core():
            self._worker = self._worker or RenderWorker(build_renderer)
            camera.request_picture = PictureQueue(self._worker, camera.picture, camera.lens.pinhole, pictures).request

    def _open_renderer(self, description: CameraDescription, open_renderer: Callable[[], Renderer]) -> Renderer:
        if self._choice == "painted":
            return self._painter
        try:
            return open_renderer()
        except NoOpenGL as missing:
            if self._choice == "rendered":
                text = f"{missing}. Or paint the pictures: --option camera=painted"
                raise DeviceError(description.name, text, kind="no-opengl") from missing
            self.notes = [f"the pictures of the cameras are painted, because {missing}"]
            return self._painter

    @cached_property
    def _painter(self) -> PaintedRenderer:
        return PaintedRenderer(self._state.world)
