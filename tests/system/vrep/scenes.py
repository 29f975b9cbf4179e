"""Scenes for the checks, built over the ZeroMQ remote API of the same simulator.

The ZeroMQ client disconnects before a legacy client connects. While a legacy client steps the simulation, the ZeroMQ
server does not answer.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from drivers.coppeliasim.builder import FORWARD, CollisionMask, Placement, SceneBuilder
from drivers.coppeliasim.connection import LOADING_S, SimulatorConnection
from robotcore.description import load_robot
from robotcore.kinds.camera import CameraDescription
from robotcore.kinds.range_sensor import RangeSensorDescription
from robotcore.testing import worlds
from tests.system.coppeliasim import server

SIGHT_PX = 256
SIGHT_RAD = 1.05
BALL_M = (1.0, 0.15, 0.1)
"""The position of the ball in metres. v0 sees it on the left, below the middle."""

BALL_AWAY_M = 2.5
WALL_M = 0.35
"""The distance from bubbleRob's nose to the wall, in metres."""

_PERSPECTIVE, _EXTERNAL = 2, 16
_CONE, _ULTRASONIC = 34, 16


def require_builder() -> None:
    """Skip the check if no ZeroMQ remote API can build its scene."""
    if server.address() is None:
        pytest.skip(f"needs a built scene. Set {server.VARIABLE}=HOST:PORT of the same simulator too")


@contextmanager
def rover() -> Iterator[None]:
    """Build the rover on open ground, with a distant ball in front of it."""
    require_builder()
    eye = load_robot("rover").first_of(CameraDescription)
    assert eye
    try:
        server.open_robot(worlds.ball(eye.mount, BALL_AWAY_M, 0.0), keep=True).close()
        yield
    finally:
        server.open_robot(worlds.empty()).close()


@contextmanager
def bubblerob() -> Iterator[bool]:
    """Build bubbleRob with its old names in front of a wall, and yield whether its nose works.

    Without the plug-in, proximity sensors can be created, but detect nothing.
    """
    require_builder()
    robot = load_robot("bubblerob").model_copy(update={"backends": {}})
    nose = robot.first_of(RangeSensorDescription)
    assert nose
    try:
        server.open_robot(worlds.wall(nose.mount, WALL_M), robot=robot, keep=True).close()
        with server.connect() as other:
            is_working = _rename_parts(other)
        yield is_working
    finally:
        server.open_robot(worlds.empty()).close()


@contextmanager
def relay() -> Iterator[None]:
    """Build two vision sensors: v0 sees a green ball, and v1 shows received pictures.

    The sensors see only the ball. CoppeliaSim 4.10 may crash if a removed sensor has seen an object with a texture.
    """
    require_builder()
    created: list[int] = []
    try:
        with server.connect() as other:
            builder = SceneBuilder(other)
            created.append(
                builder.create_shape(
                    "spheroid", [0.2] * 3, Placement(*BALL_M), (38, 178, 64), CollisionMask.THING, "ball"
                )
            )
            for name, options, place in (
                ("v0", _PERSPECTIVE, FORWARD._replace(z=0.3)),
                ("v1", _PERSPECTIVE | _EXTERNAL, Placement(0.0, 0.0, 3.0)),
            ):
                floats = [0.02, 10.0, SIGHT_RAD, 0.02, 0, 0, 0, 0, 0, 0, 0]
                created.append(builder.make("createVisionSensor", options, [SIGHT_PX, SIGHT_PX, 0, 0], floats))
                builder.set_int(created[-1], "visionintparam_entity_to_render", created[0])
                builder.put(created[-1], place, name, -1)
        yield
    finally:
        with server.connect() as other:
            stop(other)
            SceneBuilder(other).call("removeObjects", created)


@contextmanager
def running() -> Iterator[None]:
    """Run the simulation without lockstep. At the end, check that it still runs, and stop it."""
    with server.connect() as other:
        other.sim("startSimulation", within_s=LOADING_S)
    try:
        yield
        with server.connect() as other:
            assert other.sim("getSimulationState") != other.constant("simulation_stopped")
    finally:
        with server.connect() as other:
            stop(other)


def serve(port: int) -> None:
    """Start another server of the legacy remote API, as a script of a running scene does."""
    with server.connect() as other:
        assert other.call("simRemoteApi.start", port) == 1


def read_screen() -> bytes:
    """Return the picture of v1: RGB, the lowest row first."""
    with server.connect() as other:
        picture, size = other.sim("getVisionSensorImg", other.sim("getObject", "/v1"))
    assert size == [SIGHT_PX, SIGHT_PX]
    return bytes(picture)


def stop(other: SimulatorConnection) -> None:
    """Stop the simulation, and wait until it has stopped."""
    if other.sim("getSimulationState") != other.constant("simulation_stopped"):
        other.sim("stopSimulation", True, within_s=LOADING_S)


def _rename_parts(other: SimulatorConnection) -> bool:
    builder = SceneBuilder(other)
    for side in ("left", "right"):
        joint = other.sim("getObject", f"/bubblerob/{side}_motor")
        builder.call("setObjectAlias", joint, f"bubbleRob_{side}Motor")
    nose = other.sim("getObject", "/bubblerob/nose", {"noError": True})
    is_working = nose >= 0 and other.sim("getObjectType", nose) == other.constant("sceneobject_proximitysensor")
    if not is_working:
        sizes, reach = [32, 0, 4, 1, 1, 1, 0, 0], [0.0, 0.5, *[0.0] * 10, 0.01, 0.0, 0.0]
        nose = builder.make("createProximitySensor", _CONE, _ULTRASONIC, 0, sizes, reach)
        builder.put(nose, FORWARD._replace(x=0.05, z=0.12), "", other.sim("getObject", "/bubblerob"))
    builder.call("setObjectAlias", nose, "bubbleRob_sensingNose")
    return bool(is_working)
