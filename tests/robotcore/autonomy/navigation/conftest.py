from __future__ import annotations

import pytest

from robotcore.autonomy.navigation.mapping import Map
from tests.robotcore.autonomy.navigation.places import HERE, REACH


@pytest.fixture
def field() -> Map:
    """An open circle of two metres round the robot, all of it known to be free and looked at."""
    known = Map(HERE, REACH)
    known.grid.evidence[known.grid.disc(0.0, 0.0, 2.0)] = -1.0
    known.coverage.looked_at[:] = True
    return known
