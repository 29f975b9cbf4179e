"""The sensors and the contacts of a robot whose body a physics engine moves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robotcore.description import Mount
from robotcore.errors import DeviceError
from robotcore.geometry import Pose
from robotcore.hal.clock import Clock
from robotcore.kinds.camera import CameraDescription, Render, SimulatedCamera
from robotcore.optics import CameraView, Image, Intrinsics

Array = NDArray[np.float64]
ObjectIds = NDArray[np.int32]

Transform = Callable[[], tuple[Array, Array]]
"""Returns the pose of the robot's frame in the world: a rotation matrix (3, 3), and an origin (3,) in metres."""


Locate = Callable[[Mount], Mount]
"""Returns the present mount of a device for its mount in the robot's file. A servo may have turned it."""


class NoOpenGL(Exception):  # noqa: N818  each caller raises an error of robotcore in its place
    """OpenGL is not available on this machine. The message names the missing library or function."""


class Renderer(Protocol):
    """Renders the pictures of a simulation. Without OpenGL, a renderer that needs it raises NoOpenGL."""

    @property
    def things(self) -> Mapping[str, int]:
        """The ids of the things in a segmentation, by the name of the thing."""

    def picture(self, view: CameraView) -> Image:
        """Return the picture of a view, (height, width, 3), BGR."""

    def segmentation(self, view: CameraView) -> ObjectIds:
        """Return the id of the object at each pixel of a view, (height, width); -1 for the sky."""


class BodyCamera(SimulatedCamera):
    """A camera on a body. ``things`` and ``segmentation`` are those of its renderer."""

    def __init__(
        self,
        description: CameraDescription,
        clock: Clock,
        transform: Transform,
        locate: Locate,
        renderer: Renderer,
        seed: int,
    ) -> None:
        def capture(pinhole: Intrinsics) -> Render:
            rotation, origin = transform()
            local = CameraView.of(pinhole, locate(description.mount), Pose(0.0, 0.0, 0.0))
            view = CameraView(pinhole, origin + rotation @ local.eye, local.rotation @ rotation.T)
            return self.request_picture(view)

        self.request_picture: Callable[[CameraView], Render] = lambda view: partial(self.picture, view)
        """Returns the function that renders the picture of a captured view."""
        super().__init__(description, clock, capture, seed)
        self.things, self.segmentation = renderer.things, renderer.segmentation
        self._renderer = renderer

    def picture(self, view: CameraView) -> Image:
        """Return the picture of a view, which may differ from the view of this camera."""
        try:
            return self._renderer.picture(view)
        except NoOpenGL as error:
            raise DeviceError(self.name, str(error), kind="no-opengl") from error


class ContactCounter:
    """Counts the contacts of a robot's body with other bodies. A contact counts once, even if it lasts."""

    def __init__(self) -> None:
        self.count = 0
        self._touched: set[int] = set()

    @property
    def touched(self) -> frozenset[int]:
        """The bodies that the robot touches now."""
        return frozenset(self._touched)

    def update(self, touching: set[int], is_near: Callable[[int], bool]) -> None:
        """Count the contacts that began in the last physics step.

        touching: the bodies that the robot touches.
        is_near: returns whether the gap to a body is at most `RELEASE_M`. A greater gap ends a contact.
        """
        self.count += len(touching - self._touched)
        self._touched = touching | {body for body in self._touched if is_near(body)}
