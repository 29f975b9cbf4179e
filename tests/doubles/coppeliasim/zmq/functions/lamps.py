"""Lamps."""

from __future__ import annotations

from typing import Any

from tests.doubles.coppeliasim.scene.objects import Lamp
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session


@function("getLightParameters")
def get_light_parameters(session: Session, lamp: Lamp) -> tuple[int, list[float], list[float], list[float]]:
    """Return whether it is on, a relic, and its diffuse and specular colours."""
    return int(lamp.is_on), [0.0, 0.0, 0.0], list(lamp.diffuse), list(lamp.specular)


@function("setLightParameters")
def set_light_parameters(
    session: Session,
    lamp: Lamp,
    state: int,
    relic: Any = None,
    diffuse: Any = None,
    specular: Any = None,
) -> None:
    lamp.is_on, lamp.is_set = bool(state), True
    if diffuse:
        lamp.diffuse = (float(diffuse[0]), float(diffuse[1]), float(diffuse[2]))
    if specular:
        lamp.specular = (float(specular[0]), float(specular[1]), float(specular[2]))
    session.simulator.graph.revision += 1
