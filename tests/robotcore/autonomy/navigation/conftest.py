from __future__ import annotations

import pytest

from robotcore.autonomy.navigation.mapping import Map
from tests.robotcore.autonomy.navigation.places import HERE, REACH


@pytest.fixture
def field() -> Map:
    """Return a map with a circle of 2 m around the robot that is free and seen."""
    known = Map(HERE, REACH)
    known.grid.evidence[known.grid.disc(0.0, 0.0, 2.0)] = -1.0
    known.coverage.seen[:] = True
    return known
