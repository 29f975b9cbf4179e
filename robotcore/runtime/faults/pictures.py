"""Pictures that are worse than the camera's."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from robotcore.hal.devices import Camera, Frame, Image
from robotcore.runtime.faults.fault import Fault, Kind
from robotcore.runtime.faults.occasion import Occasion
from robotcore.runtime.layers.conditions import Developed, grain
from robotcore.runtime.layers.layer import Layer
from robotcore.runtime.layers.readers import Reader

GreyLevels = Annotated[float, Field(gt=0, le=64, description="grey levels")]


class CameraNoise(Fault):
    """Adds normal noise of this deviation to each pixel."""

    on = frozenset({Kind.CAMERA})
    example = "camera noise=20 after=5"

    value: GreyLevels

    def layer(self, occasion: Occasion) -> Grainy:
        return Grainy(self, self.value, occasion)


class Grainy(Layer):
    """Adds noise to the pictures that are captured while ``fault`` is there."""

    def __init__(self, fault: Fault, sigma: float, occasion: Occasion) -> None:
        self._fault, self._sigma, self._occasion = fault, sigma, occasion

    def camera(self, camera: Camera, read: Reader[Frame]) -> Reader[Frame]:
        grainy = grain(self._occasion.noise(camera.name, self._sigma))

        def effect(image: Image, time: float) -> Image:
            return grainy(image, time) if self._fault.is_on(time) else image

        return Developed(read, [effect])
