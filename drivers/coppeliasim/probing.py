"""A box in front of a sensor, to find out whether it sees anything at all."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from drivers.coppeliasim.placing import LOOK, Placement
from drivers.coppeliasim.workshop import NOTHING, Workshop

BOX_M = 0.45
"""How far the box's near side is from the sensor."""

_SIDE_M = 0.1
_AWAY = Placement(0.0, 0.0, 900.0)
"""Where nothing else is."""


@contextmanager
def box_before(workshop: Workshop, make: Callable[[], int]) -> Iterator[int]:
    """Make a sensor with a box right in front of it, far from all else, and remove both; yields the sensor."""
    made: list[int] = []
    try:
        cuboid = workshop.constant("primitiveshape_cuboid")
        made.append(box := workshop.make("createPrimitiveShape", cuboid, [_SIDE_M] * 3, 0))
        workshop.mark(box, NOTHING)
        made.append(sensor := make())
        workshop.mark(sensor, NOTHING)
        workshop.put(box, _AWAY._replace(x=BOX_M + _SIDE_M / 2), "robotcore_probe", -1)
        workshop.put(sensor, _AWAY.at(LOOK), "robotcore_probe_sensor", -1)
        yield sensor
    finally:
        workshop.call("removeObjects", made)
