"""Proximity sensors. Where nothing is detected, every value says so."""

from __future__ import annotations

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.objects import ProximitySensor
from tests.doubles.coppeliasim.scene.ranging import Detection
from tests.doubles.coppeliasim.scene.states import State
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session

HANDLE_ALL = -2

Answer = tuple[int, float, list[float], int, list[float]]


@function("readProximitySensor")
def read_proximity_sensor(session: Session, sensor: ProximitySensor) -> Answer:
    """What was detected in the last step; nothing while stopped."""
    if session.simulator.state is State.STOPPED and not sensor.explicit:
        return _answer(None)
    return _answer(session.simulator.detection(sensor))


@function("handleProximitySensor")
def handle_proximity_sensor(session: Session, sensor: ProximitySensor) -> Answer:
    _require_explicit(sensor)
    return _answer(session.simulator.detection(sensor))


@function("checkProximitySensor")
def check_proximity_sensor(session: Session, sensor: ProximitySensor, entity: int) -> Answer:
    if entity != HANDLE_ALL:
        raise SceneError("the double checks proximity sensors against all objects only.")
    return _answer(session.simulator.detection(sensor))


@function("resetProximitySensor")
def reset_proximity_sensor(session: Session, sensor: ProximitySensor) -> int:
    """Nothing is remembered of a sensor that this would have to forget."""
    _require_explicit(sensor)
    return 1


def _require_explicit(sensor: ProximitySensor) -> None:
    if not sensor.explicit:
        raise SceneError("object not tagged for explicit handling.")


def _answer(detection: Detection | None) -> Answer:
    if detection is None:
        return 0, 0.0, [0.0, 0.0, 0.0], -1, [0.0, 0.0, 0.0]
    return 1, detection.distance, list(detection.point), detection.handle, list(detection.normal)
