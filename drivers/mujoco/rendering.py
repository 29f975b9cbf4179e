"""Renderers, one for each size of picture, and the OpenGL without a screen that they need."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from drivers.mujoco.model.groups import SEEN
from robotcore.devices import Image, Intrinsics
from robotcore.errors import DeviceError

if TYPE_CHECKING:
    from mujoco import MjData, MjModel, Renderer

_GROUPS = 6


class Renderers:
    """Renders what the model's cameras see; closed together."""

    def __init__(self, model: MjModel, data: MjData) -> None:
        self._model, self._data = model, data
        self._made: dict[tuple[int, int], Renderer] = {}
        self._options: Any = None

    def of(self, device: str, size: Intrinsics) -> Renderer:
        """Return the renderer of that size; raises DeviceError, by the device's name, where none can be had."""
        key = (size.height, size.width)
        if key not in self._made:
            self._made[key] = self._make(device, *key)
        return self._made[key]

    def picture(self, camera: str, size: Intrinsics) -> Image:
        """Return what a camera sees now, RGB, (height, width, 3), top-left origin."""
        renderer = self.of(camera, size)
        renderer.update_scene(self._data, camera, self._options)
        image: Image = renderer.render()
        return image

    def close(self) -> None:
        """Let the renderers go: one that is left open complains when the process ends. May be called again."""
        while self._made:
            self._made.popitem()[1].close()

    def _make(self, device: str, height: int, width: int) -> Renderer:
        import mujoco

        self._options = mujoco.MjvOption()
        self._options.geomgroup[:] = [group in SEEN for group in range(_GROUPS)]
        try:
            return mujoco.Renderer(self._model, height, width)
        except Exception as error:
            raise DeviceError(device, f"there is no OpenGL without a screen: {error}. Install libegl1") from error
