"""Whether the simulator can simulate proximity sensors."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from drivers.vrep.scene import SteppedScene
from drivers.vrep.wire import requests
from drivers.vrep.wire.codec import Group
from drivers.vrep.wire.errors import RefusedError
from drivers.vrep.wire.requests import Request
from tests.texts import CheckText

SHAPE, DUMMY = 7, 42


class ScriptedConnection:
    """Answers requests as a CoppeliaSim with one shape does. ``distances`` are the measured distances."""

    def __init__(self, version: int, distances: list[float]) -> None:
        self.version, self.removed = version, list[int]()
        self._distances: Iterator[float] = iter(distances)

    def call(self, request: Request[object]) -> object:
        if request == requests.OBJECT_TYPES:
            return Group((SHAPE,), (0,), ())
        if request == requests.CLOCK:
            return self.version
        if request == requests.CREATE_DUMMY:
            return DUMMY
        if request == requests.distance(SHAPE, DUMMY):
            if (distance := next(self._distances, None)) is None:
                raise RefusedError("refused", action=request.action)
            return distance
        if request == requests.remove_object(DUMMY):
            self.removed.append(DUMMY)
        return None


@pytest.mark.parametrize(
    "version, distances",
    [(41000, [999.5, 1999.5]), (41000, []), (30602, [])],
    ids=["measures", "refuses", "V-REP"],
)
def test_proximity_sensors_of_a_complete_simulator_are_accepted(version: int, distances: list[float]) -> None:
    connection = ScriptedConnection(version, distances)
    assert SteppedScene(connection).diagnose_sensor(1) is None  # type: ignore[arg-type]
    assert connection.removed == [DUMMY] * (version > 40000)


@pytest.mark.parametrize("distances", [[0.0, 0.0], [3.64, 3.64], [1.62, -5481547.5]])
def test_simulator_that_measures_no_distances_is_refused(distances: list[float], check_text: CheckText) -> None:
    connection = ScriptedConnection(41000, distances)
    check_text(SteppedScene(connection).diagnose_sensor(1))  # type: ignore[arg-type]
    assert connection.removed == [DUMMY]
