"""The maps of the report: the paths of all runs in a world, from above. North is up."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import NamedTuple
from xml.etree.ElementTree import Element

from robotcore.description import WorldDescription
from robotcore.sweep.record import Record, TruePath
from robotcore.sweep.report.drawing import Point, dot, element, group, line, polyline, render_svg
from robotcore.sweep.report.series import Series
from robotcore.sweep.statistics import subsample

MAX_PATHS = 100
"""The maximum number of paths of passing runs in a map. The same number limits the paths of failing runs."""

CM = 100.0
"""The units of a map per metre. A unit is a centimetre. Coordinates are whole units, which keeps files small."""

_MARGIN_CM = 12.0
_STEP_M = 0.03
"""The minimum distance between two successive points of a drawn path, in metres."""


class WorldMap(NamedTuple):
    """The map of one world with the paths of its runs."""

    world: str
    """The name of the world; empty if the backend has none."""

    drawing: str
    """The map as SVG."""

    caption: str
    """The numbers of passing and failing runs, as text."""


class _Chart(NamedTuple):
    """The transform from metres in a world to centimetres in its map, whose y axis points down."""

    half_width: float
    half_height: float

    def at(self, x: float, y: float) -> Point:
        """Return the point of the map, in centimetres, for a point of the world, in metres."""
        return round(self.half_width + x * CM), round(self.half_height - y * CM)


def draw_maps(series: Sequence[Series], worlds: Mapping[str, WorldDescription]) -> list[WorldMap]:
    """Return a map of each world in which a run has a true path.

    worlds: the descriptions of the worlds by name. A world without a description is drawn without floor and walls.
    """
    gathered: dict[str, list[Record]] = {}
    for each in series:
        gathered.setdefault(each.group.world, []).extend(record for record in each.records if _has_path(record))
    return [_draw_map(name, records, worlds.get(name)) for name, records in gathered.items() if records]


def _has_path(record: Record) -> bool:
    """Return whether a run has a path of finite numbers. A simulation that failed may have returned NaN."""
    return bool(record.path) and all(map(math.isfinite, chain.from_iterable(record.path or ())))


def _draw_map(name: str, records: Sequence[Record], world: WorldDescription | None) -> WorldMap:
    paths: dict[bool, list[TruePath]] = {False: [], True: []}
    for record in records:
        paths[record.is_failure].append(record.path or ())
    caption = f"passing runs: {_format_count(paths[False])}, failing: {_format_count(paths[True])}"
    passing, failing = subsample(paths[False], MAX_PATHS), subsample(paths[True], MAX_PATHS)
    chart = _make_chart([*passing, *failing], world)
    is_unseeded = all(record.result.seed is None for record in records)
    parts = [
        *(_draw_ground(chart, world) if world else ()),
        *(_draw_objects(chart, world) if world and is_unseeded else ()),
        group((_draw_path(chart, path) for path in passing), class_="paths passing"),
        group((_draw_path(chart, path) for path in failing), class_="paths failing"),
        group((dot(chart.at(*path[-1][1:]), 4) for path in passing), class_="ends passing"),
        group((_draw_cross(*chart.at(*path[-1][1:])) for path in failing), class_="ends failing"),
    ]
    words = f"Paths in {name or 'no world'}, from above: {caption}"
    return WorldMap(name, render_svg(2 * chart.half_width, 2 * chart.half_height, words, parts, class_="map"), caption)


def _format_count(paths: Sequence[TruePath]) -> str:
    return str(len(paths)) if len(paths) <= MAX_PATHS else f"{MAX_PATHS} of {len(paths)}"


def _make_chart(paths: Sequence[TruePath], world: WorldDescription | None) -> _Chart:
    points = [(abs(x), abs(y)) for path in paths for _, x, y in path]
    if world:
        wall = world.walls.thickness_m if world.walls else 0.0
        points.append((world.floor.length_m / 2 + wall, world.floor.width_m / 2 + wall))
    return _Chart(*(math.ceil(max(reach) * CM + _MARGIN_CM) for reach in zip(*points, strict=True)))


def _draw_ground(chart: _Chart, world: WorldDescription) -> Iterator[Element]:
    x, y = world.floor.length_m / 2, world.floor.width_m / 2
    if world.walls:
        yield _draw_rectangle(chart, x + world.walls.thickness_m, y + world.walls.thickness_m, "wall")
    yield _draw_rectangle(chart, x, y, "floor")
    columns = [line(chart.at(metre, y), chart.at(metre, -y)) for metre in range(-math.floor(x), math.floor(x) + 1)]
    rows = [line(chart.at(-x, metre), chart.at(x, metre)) for metre in range(-math.floor(y), math.floor(y) + 1)]
    yield group([*columns, *rows], class_="grid")
    if image := world.floor.image:
        left, bottom, right, top = image.limits
        x, y = chart.at(left, top)
        yield element(
            "image",
            x=x,
            y=y,
            width=(right - left) * CM,
            height=(top - bottom) * CM,
            href=f"data:image/png;base64,{image.content}",
        )
    for each in world.lines:
        points = (*each.points_m, *each.points_m[: int(each.closed)])
        colour = f"rgb{each.colour}"
        yield polyline(
            (chart.at(*point) for point in points), class_="line", stroke=colour, stroke_width=each.width_m * CM
        )


def _draw_rectangle(chart: _Chart, x: float, y: float, kind: str) -> Element:
    left, top = chart.at(-x, y)
    return element("rect", x=left, y=top, width=2 * x * CM, height=2 * y * CM, class_=kind)


def _draw_objects(chart: _Chart, world: WorldDescription) -> Iterator[Element]:
    outlines = [("obstacle", each.outline) for each in world.obstacles]
    outlines += [("target", each.outline) for each in world.targets]
    for kind, corners in outlines:
        points = (chart.at(x, y) for x, y in corners)
        yield element("polygon", points=" ".join(f"{x:g},{y:g}" for x, y in points), class_=kind)


def _draw_path(chart: _Chart, path: TruePath) -> Element:
    """Draw those points of a path that are at least `_STEP_M` away from the previously drawn point."""
    points: list[Point] = []
    for _, x, y in path:
        if not points or math.dist(points[-1], (x, y)) >= _STEP_M:
            points.append((x, y))
    return polyline(chart.at(x, y) for x, y in points)


def _draw_cross(x: float, y: float) -> Element:
    return element("path", d=f"M{x - 5:g} {y - 5:g}l10 10m0 -10l-10 10")
