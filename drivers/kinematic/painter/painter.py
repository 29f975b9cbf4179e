"""The painter: sky and ground, then the things of a world from the farthest to the nearest."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robotcore.description import WorldDescription
from robotcore.devices import Image
from robotcore.projection import View

from drivers.kinematic.painter.faces import Faces, Facet
from drivers.kinematic.painter.order import Partitions, back_to_front
from drivers.kinematic.painter.shading import Inks, inks_of, ramp_of, sky_ink
from drivers.kinematic.painter.scanline import fill
from drivers.kinematic.painter.spheres import Disc, disc_of

Array = NDArray[np.float64]
Labels = NDArray[np.uint32]


class Painter:
    """Paints what a camera sees of a world: exact at pixel centres, without anti-aliasing, without shadows."""

    def __init__(self, world: WorldDescription) -> None:
        self.things = tuple(thing.name for thing in (*world.prisms, *world.targets))
        self._balls = world.targets
        self._first_ball = len(world.prisms)
        self._lamp = np.array(world.light.direction)
        self._faces = Faces(world)
        self._partitions = Partitions(world)
        floor = np.array([world.floor.colour], dtype=np.float64)
        self._ground = int(inks_of(floor, self._lamp[2:], world.light)[0])
        self._sky = int(sky_ink(world.light))
        self._ramps = [ramp_of(ball.colour, world.light) for ball in world.targets]

    def picture(self, view: View) -> Image:
        """Return the picture, (height, width, 3), BGR."""
        import cv2

        canvas = _canvas(view)
        canvas[:] = np.where(_is_ground(view), self._ground, self._sky)[:, None]
        for stroke in self._strokes(view):
            if isinstance(stroke, Facet):
                fill(canvas, stroke.polygon, int(self._faces.inks[stroke.face]))
            else:
                stroke.paint(canvas, self._ramps[stroke.thing - self._first_ball])
        return np.asarray(cv2.cvtColor(canvas.view(np.uint8).reshape(*canvas.shape, 4), cv2.COLOR_BGRA2BGR))

    def labels(self, view: View) -> Labels:
        """Return what each pixel shows, (height, width): one more than its place in ``things``; 0 is none of them."""
        canvas = _canvas(view)
        canvas[:] = 0
        for stroke in self._strokes(view):
            if isinstance(stroke, Facet):
                fill(canvas, stroke.polygon, stroke.thing + 1)
            else:
                canvas[stroke.rows, stroke.columns][stroke.is_hit] = stroke.thing + 1
        return canvas
