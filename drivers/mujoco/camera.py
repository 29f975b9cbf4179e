"""The camera: what it sees is rendered when it is read, and only then."""

from __future__ import annotations

from collections.abc import Mapping

from drivers.mujoco.body import Body
from drivers.mujoco.opengl import NoOpenGL
from drivers.mujoco.rendering import Numbers, Renderer
from robotcore.description import CameraDescription
from robotcore.errors import DeviceError
from robotcore.geometry import Pose
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Camera, Frame, Image
from robotcore.optics import View
from robotcore.simulation.sampling import OnceAnInstant


class MujocoCamera(Camera):
    """A camera on the robot's body; it tilts with it. ``things`` maps names to the `numbers` of a picture's pixels."""

    def __init__(
        self, description: CameraDescription, clock: Clock, body: Body, renderer: Renderer, things: Mapping[str, int]
    ) -> None:
        super().__init__(description.name, description.intrinsics)
        self.things = things
        self._body, self._renderer = body, renderer
        self._on_body = View.of(self.intrinsics, description.mount, Pose(0.0, 0.0, 0.0))
        self._newest_at = OnceAnInstant(clock, self._expose)

    def picture(self, view: View) -> Image:
        """Render what any camera would see; works without the robot being there. BGR, read-only."""
        try:
            image = self._renderer.picture(view)
        except NoOpenGL as error:
            raise DeviceError(self.name, str(error)) from error
        image.flags.writeable = False
        return image

    def numbers(self, view: View) -> Numbers:
        """Return which thing each pixel of such a picture shows, (height, width), by its number; -1: sky."""
        return self._renderer.numbers(view)

    def _newest(self) -> Frame:
        return self._newest_at()

    def _expose(self, time: float, sequence: int) -> Frame:
        return Frame(self.picture(self._view()), time, sequence)

    def _view(self) -> View:
        rotation, origin = self._body.transform()
        local = self._on_body
        return View(self.intrinsics, origin + rotation @ local.eye, local.rotation @ rotation.T)
