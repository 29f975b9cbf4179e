"""Paint the picture of a camera: sky, ground, picture and lines on it, then bodies from the farthest to the nearest."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from robotcore.description import WorldDescription
from robotcore.optics import CameraView, Image
from robotcore.simulation.painter.canvas import (
    Mark,
    Palette,
    PixelBuffer,
    Stroke,
    pack_colours,
    shade,
    shade_picture,
    shade_ramp,
)
from robotcore.simulation.painter.faces import Block, Faces, Facet, split_into_blocks
from robotcore.simulation.painter.floor_lines import FloorLines
from robotcore.simulation.painter.floor_picture import FloorPicture
from robotcore.simulation.painter.occlusion import OcclusionPlanes
from robotcore.simulation.painter.spheres import Sphere
from robotcore.simulation.painter.texturing import Texturing

Labels = NDArray[np.uint32]

_BLANK = np.zeros((1, 1), dtype=np.uint32)
"""The picture on the floor in a palette that does not distinguish it."""


class Painter:
    """Paints the picture that a camera takes of a world, without anti-aliasing and without shadows.

    A pixel has the exact colour of the point that the ray through its centre meets. ``things`` holds the names of the
    world's bodies: first the prisms, then the targets.

    >>> from robotcore.description import Mount, load_world
    >>> from robotcore.optics import Intrinsics
    >>> from robotcore.geometry import Pose
    >>> painter = Painter(load_world("open"))
    >>> view = CameraView.of(Intrinsics(64, 48, 1.0), Mount(z_m=0.1), Pose(1.3, -0.6, 0.0))
    >>> painter.picture(view).shape, painter.things[painter.labels(view)[24, 32] - 1]
    ((48, 64, 3), 'ball')
    """

    def __init__(self, world: WorldDescription) -> None:
        self.things = tuple(thing.name for thing in (*world.prisms, *world.targets))
        blocks = split_into_blocks(world)
        self._faces = Faces(blocks)
        self._picture, self._lines = FloorPicture(world.floor.image), FloorLines(world.lines)
        self._balls = dict(enumerate(world.targets, start=len(blocks)))
        self._lamp = np.array(world.light.direction)
        discs = np.array([(ball.x_m, ball.y_m, ball.radius_m) for ball in world.targets]).reshape(-1, 3)
        self._planes = OcclusionPlanes([block.outline for block in blocks], discs)
        self._colours = self._create_colour_palette(world)
        self._labels = self._create_label_palette(blocks)
        self._texturing = Texturing(world, blocks, self._faces)
        self._surfaces = self._create_surface_palette(self._texturing.numbers)

    def picture(self, view: CameraView) -> Image:
        """Paint the picture of a camera, and return it, (height, width, 3), BGR."""
        import cv2

        order = list(self._iterate_back_to_front(view))
        canvas = _paint_marks(view, order, self._colours)
        if self._texturing.is_needed:
            facets = [mark for mark in order if isinstance(mark, Facet)]
            self._texturing.paint(canvas, _paint_marks(view, order, self._surfaces), view, facets)
        pixels = canvas.view(np.uint8).reshape(*canvas.shape, 4)
        return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGRA2BGR), dtype=np.uint8)

    def labels(self, view: CameraView) -> Labels:
        """Return for each pixel the label of the body that it shows, (height, width).

        The label is 1 plus the index of the body in ``things``. Sky and ground have the label 0.
        """
        return _paint_marks(view, self._iterate_back_to_front(view), self._labels)

    def _iterate_back_to_front(self, view: CameraView) -> Iterator[Mark]:
        yield from self._picture.marks(view)
        yield from self._lines.marks(view)
        shown: dict[int, list[Stroke]] = {}
        columns: dict[int, tuple[float, float]] = {}
        for stroke in self._strokes(view):
            first, last = stroke.columns
            begin, end = columns.get(stroke.part, (first, last))
            columns[stroke.part] = min(begin, first), max(end, last)
            shown.setdefault(stroke.part, []).append(stroke)
        for part in self._planes.sort_back_to_front(view.eye, columns):
            yield from shown[part]

    def _strokes(self, view: CameraView) -> Iterator[Stroke]:
        yield from self._faces.facets(view)
        for part, ball in self._balls.items():
            yield from Sphere.from_ball(ball, view, self._lamp, part).bands(view.intrinsics)

    def _create_colour_palette(self, world: WorldDescription) -> Palette:
        light, floor = world.light, world.floor
        return Palette(
            sky=int(pack_colours(np.array([light.sky_colour]))[0]),
            ground=int(shade(np.array([floor.colour]), self._lamp[2:], light)[0]),
            picture=shade_picture(floor.image.render(floor.colour), self._lamp[2], light) if floor.image else _BLANK,
            lines=shade(self._lines.colours, self._lamp[2:], light).tolist(),
            faces=self._faces.shade(light).tolist(),
            balls={part: shade_ramp(ball.colour, light) for part, ball in self._balls.items()},
        )

    def _create_label_palette(self, blocks: Sequence[Block]) -> Palette:
        first_ball = len(self.things) - len(self._balls) + 1
        return Palette(
            sky=0,
            ground=0,
            picture=_BLANK,
            lines=self._lines.zeros,
            faces=[blocks[number].prism_index + 1 for number in self._faces.block_numbers],
            balls={part: np.array([n], np.uint32) for n, part in enumerate(self._balls, start=first_ball)},
        )

    def _create_surface_palette(self, numbers: Sequence[int]) -> Palette:
        ground, *faces = numbers
        balls = dict.fromkeys(self._balls, np.zeros(1, np.uint32))
        return Palette(sky=0, ground=ground, picture=_BLANK, lines=self._lines.zeros, faces=faces, balls=balls)


def _paint_marks(view: CameraView, marks: Iterable[Mark], palette: Palette) -> PixelBuffer:
    canvas = _create_canvas(view, palette)
    for mark in marks:
        mark.paint(canvas, palette)
    return canvas


def _create_canvas(view: CameraView, palette: Palette) -> PixelBuffer:
    i = view.intrinsics
    right, down, forward = view.rotation[:, 2].tolist()
    rises = (np.arange(i.height) - i.cy) * down + i.focal_length * forward  # the rays of the middle column
    canvas = np.empty((i.height, i.width), dtype=np.uint32)
    is_ground = rises < 0
    horizon = np.count_nonzero(is_ground == is_ground[0])
    canvas[:horizon] = palette.ground if is_ground[0] else palette.sky
    canvas[horizon:] = palette.ground if is_ground[-1] else palette.sky
    if right:  # the camera rolls, so some rows have sky and ground
        rows = np.flatnonzero(np.abs(rises) < abs(right) * i.width / 2)
        across = (np.arange(i.width) - i.cx) * right
        canvas[rows] = np.where(rises[rows, None] + across < 0, palette.ground, palette.sky)
    return canvas
