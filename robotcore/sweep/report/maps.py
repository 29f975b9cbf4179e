"""The maps of the report: the paths of all runs in a world, from above. North is up."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
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

_GRID_M = 1.0


@dataclass(frozen=True)
class WorldMap:
    """The map of one world with the paths of its runs."""

    world: str
    """The name of the world; empty if the backend has none."""

    drawing: str
    """The map as SVG."""

    caption: str
    """The numbers of passing and failing runs, as text."""


@dataclass(frozen=True)
class MapScale:
    """The transform from metres in a world to centimetres in its map, whose y axis points down."""

    half_width: float
    """The x coordinate of the world's origin in the map, in centimetres. It is half the width of the map."""

    half_height: float
    """The y coordinate of the world's origin in the map, in centimetres. It is half the height of the map."""

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
    passing = [record for record in records if not record.is_failure]
    failing = [record for record in records if record.is_failure]
    caption = f"passing runs: {_format_count(passing)}, failing: {_format_count(failing)}"
    passing, failing = subsample(passing, MAX_PATHS), subsample(failing, MAX_PATHS)
    chart = _make_scale([*passing, *failing], world)
    is_unseeded = all(record.result.seed is None for record in records)
    parts = [
        *(_draw_ground(chart, world) if world else ()),
        *(_draw_objects(chart, world) if world and is_unseeded else ()),
        group((_draw_path(chart, record) for record in passing), class_="paths passing"),
        group((_draw_path(chart, record) for record in failing), class_="paths failing"),
        group((_draw_end(chart, record) for record in passing), class_="ends passing"),
        group((_draw_cross(chart, record) for record in failing), class_="ends failing"),
    ]
    words = f"Paths in {name or 'no world'}, from above: {caption}"
    return WorldMap(name, render_svg(2 * chart.half_width, 2 * chart.half_height, words, parts, class_="map"), caption)


def _format_count(records: Sequence[Record]) -> str:
    return str(len(records)) if len(records) <= MAX_PATHS else f"{MAX_PATHS} of {len(records)}"


def _make_scale(records: Sequence[Record], world: WorldDescription | None) -> MapScale:
    wall = world.walls.thickness_m if world and world.walls else 0.0
    points = [(x, y) for record in records for _, x, y in record.path or ()]
    reach_x = max(abs(x) for x, _ in points)
    reach_y = max(abs(y) for _, y in points)
    if world:
        reach_x = max(reach_x, world.floor.length_m / 2 + wall)
        reach_y = max(reach_y, world.floor.width_m / 2 + wall)
    return MapScale(math.ceil(reach_x * CM + _MARGIN_CM), math.ceil(reach_y * CM + _MARGIN_CM))


def _draw_ground(chart: MapScale, world: WorldDescription) -> Iterator[Element]:
    x, y = world.floor.length_m / 2, world.floor.width_m / 2
    if world.walls:
        yield _draw_rectangle(chart, x + world.walls.thickness_m, y + world.walls.thickness_m, "wall")
    yield _draw_rectangle(chart, x, y, "floor")
    yield group(_draw_grid(chart, x, y), class_="grid")


def _draw_rectangle(chart: MapScale, x: float, y: float, kind: str) -> Element:
    left, top = chart.at(-x, y)
    return element("rect", x=left, y=top, width=2 * x * CM, height=2 * y * CM, class_=kind)


def _draw_grid(chart: MapScale, x: float, y: float) -> Iterator[Element]:
    for metre in range(-math.floor(x / _GRID_M), math.floor(x / _GRID_M) + 1):
        yield line(chart.at(metre, y), chart.at(metre, -y))
    for metre in range(-math.floor(y / _GRID_M), math.floor(y / _GRID_M) + 1):
        yield line(chart.at(-x, metre), chart.at(x, metre))


def _draw_objects(chart: MapScale, world: WorldDescription) -> Iterator[Element]:
    for obstacle in world.obstacles:
        yield _draw_outline(chart, obstacle.outline, "obstacle")
    for ball in world.targets:
        yield _draw_outline(chart, ball.outline, "target")


def _draw_outline(chart: MapScale, corners: Sequence[Point], kind: str) -> Element:
    points = (chart.at(x, y) for x, y in corners)
    return element("polygon", points=" ".join(f"{x:g},{y:g}" for x, y in points), class_=kind)


def _draw_path(chart: MapScale, record: Record) -> Element:
    return polyline(chart.at(x, y) for x, y in _simplify(record.path or ()))


def _simplify(path: TruePath) -> Iterator[Point]:
    """Yield those points of a path that are at least `_STEP_M` away from the previously yielded point."""
    last: Point | None = None
    for _, x, y in path:
        if last is None or math.dist(last, (x, y)) >= _STEP_M:
            last = x, y
            yield last


def _draw_end(chart: MapScale, record: Record) -> Element:
    return dot(chart.at(*_last_point(record)), 4)


def _draw_cross(chart: MapScale, record: Record) -> Element:
    x, y = chart.at(*_last_point(record))
    return element("path", d=f"M{x - 5:g} {y - 5:g}l10 10m0 -10l-10 10")


def _last_point(record: Record) -> Point:
    _, x, y = (record.path or ())[-1]
    return x, y
