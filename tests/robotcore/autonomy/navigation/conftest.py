from __future__ import annotations

import pytest

from robotcore.autonomy.navigation.mapping import NavigationMap
from tests.robotcore.autonomy.navigation.map_drawing import HERE, REACH


@pytest.fixture
def field() -> NavigationMap:
    """Return a map with a circle of 2 m around the robot that is free and seen."""
    known = NavigationMap(HERE, REACH)
    known.grid.evidence[known.grid.disc(0.0, 0.0, 2.0)] = -1.0
    known.coverage.seen[:] = True
    return known
