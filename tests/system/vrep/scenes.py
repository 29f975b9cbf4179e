"""Scenes to join, built over the same simulator's ZeroMQ remote API, whose client has left before the other comes.

While a legacy client lets the simulation wait, that API answers nobody: the two are never mixed.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from drivers.coppeliasim.builder import FORWARD, CollisionMask, Placement, SceneBuilder
from drivers.coppeliasim.connection import LOADING_S, Connection
from robotcore.description import CameraDescription, RangeSensorDescription, load_robot
from robotcore.testing import worlds
from tests.system.coppeliasim import server

SIGHT_PX = 256
SIGHT_RAD = 1.05
BALL_M = (1.0, 0.15, 0.1)
"""Where the ball is: as v0 sees it, to the left, and below the middle."""

BALL_AWAY_M = 2.5
WALL_M = 0.35
"""How far the wall is before bubbleRob's nose."""

_PERSPECTIVE, _EXTERNAL = 2, 16
_CONE, _ULTRASONIC = 34, 16


def need_a_builder() -> None:
    """Skip a check that joins a scene where nobody can be asked to build one."""
    if server.address() is None:
        pytest.skip(f"joins a scene that is built first: set {server.VARIABLE}=HOST:PORT of the same simulator too")


@contextmanager
def rover() -> Iterator[None]:
    """Leave the rover on open ground, far before a ball, as it is built."""
    need_a_builder()
    eye = load_robot("rover").first_of(CameraDescription)
    assert eye
    try:
        server.opened(worlds.ball(eye.mount, BALL_AWAY_M, 0.0), keep=True).close()
        yield
    finally:
        server.opened(worlds.empty()).close()


@contextmanager
def bubblerob() -> Iterator[bool]:
    """Leave bubbleRob before a wall, under its old names; yields whether its nose, a proximity sensor, sees anything.

    Without the plug-in for it, such a sensor can be made, and says that nothing is there.
    """
    need_a_builder()
    robot = load_robot("bubblerob").model_copy(update={"backends": {}})
    nose = robot.first_of(RangeSensorDescription)
    assert nose
    try:
        server.opened(worlds.wall(nose.mount, WALL_M), robot=robot, keep=True).close()
        with server.looking() as other:
            sees = _renamed(other)
        yield sees
    finally:
        server.opened(worlds.empty()).close()


@contextmanager
def relay() -> Iterator[None]:
    """Leave two vision sensors, of which v0 sees a green ball, and v1 shows what it is sent; remove them at the end.

    They see the ball and nothing else: CoppeliaSim 4.10 has been seen to crash when it drew something later that has a
    texture and was drawn before by a sensor that is gone.
    """
    need_a_builder()
    made: list[int] = []
    try:
        with server.looking() as other:
            workshop = SceneBuilder(other)
            made.append(
                workshop.shape("spheroid", [0.2] * 3, Placement(*BALL_M), (38, 178, 64), CollisionMask.THING, "ball")
            )
            for name, options, place in (
                ("v0", _PERSPECTIVE, FORWARD._replace(z=0.3)),
                ("v1", _PERSPECTIVE | _EXTERNAL, Placement(0.0, 0.0, 3.0)),
            ):
                floats = [0.02, 10.0, SIGHT_RAD, 0.02, 0, 0, 0, 0, 0, 0, 0]
                made.append(workshop.make("createVisionSensor", options, [SIGHT_PX, SIGHT_PX, 0, 0], floats))
                workshop.set_int(made[-1], "visionintparam_entity_to_render", made[0])
                workshop.put(made[-1], place, name, -1)
        yield
    finally:
        with server.looking() as other:
            halt(other)
            SceneBuilder(other).call("removeObjects", made)


@contextmanager
def running() -> Iterator[None]:
    """Let the simulation run by itself meanwhile; it has to run still at the end, when it is stopped."""
    with server.looking() as other:
        other.sim("startSimulation", within_s=LOADING_S)
    try:
        yield
        with server.looking() as other:
            assert other.sim("getSimulationState") != other.constant("simulation_stopped")
    finally:
        with server.looking() as other:
            halt(other)


def serve(port: int) -> None:
    """Start another service of the legacy API, as a script of a running scene does."""
    with server.looking() as other:
        assert other.call("simRemoteApi.start", port) == 1


def screen() -> bytes:
    """Return what v1 shows, RGB, the lowest row first."""
    with server.looking() as other:
        picture, size = other.sim("getVisionSensorImg", other.sim("getObject", "/v1"))
    assert size == [SIGHT_PX, SIGHT_PX]
    return bytes(picture)


def halt(other: Connection) -> None:
    """Stop the simulation, and wait until it has."""
    if other.sim("getSimulationState") != other.constant("simulation_stopped"):
        other.sim("stopSimulation", True, within_s=LOADING_S)


def _renamed(other: Connection) -> bool:
    workshop = SceneBuilder(other)
    for side in ("left", "right"):
        joint = other.sim("getObject", f"/bubblerob/{side}_motor")
        workshop.call("setObjectAlias", joint, f"bubbleRob_{side}Motor")
    there = other.sim("getObject", "/bubblerob/nose", {"noError": True})
    sees = there >= 0 and other.sim("getObjectType", there) == other.constant("sceneobject_proximitysensor")
    if not sees:
        sizes, reach = [32, 0, 4, 1, 1, 1, 0, 0], [0.0, 0.5, *[0.0] * 10, 0.01, 0.0, 0.0]
        there = workshop.make("createProximitySensor", _CONE, _ULTRASONIC, 0, sizes, reach)
        workshop.put(there, FORWARD._replace(x=0.05, z=0.12), "", other.sim("getObject", "/bubblerob"))
    workshop.call("setObjectAlias", there, "bubbleRob_sensingNose")
    return bool(sees)
