"""Tests of the double with CoppeliaSim's own client."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from coppeliasim_zmqremoteapi_client import RemoteAPIClient

from tests.doubles.coppeliasim.double import Double
from tests.doubles.coppeliasim.scenes import bubblerob_scene

PATIENCE_MS = 5000


@pytest.fixture
def sim() -> Iterator[Any]:
    with Double(bubblerob_scene()) as double:
        client = RemoteAPIClient(port=double.zmq_port)
        client.socket.rcvtimeo, client.socket.linger = PATIENCE_MS, 0
        yield client.require("sim")
        client.socket.close()
        client.context.term()
        del sys.modules["__main__"].__dict__["require"]


def test_robot_drives_the_rolled_distance(sim: Any) -> None:
    body = sim.getObject("/bubbleRob")
    joints = [sim.getObject(f"/bubbleRob/{side}Motor") for side in ("left", "right")]
    sim.setStepping(True)
    sim.startSimulation()
    for joint in joints:
        sim.setJointTargetVelocity(joint, 2.5)
    before = sim.getObjectPosition(body)
    for _ in range(20):
        sim.step()
    assert sim.getSimulationTime() == pytest.approx(1.0)
    assert sim.getObjectPosition(body)[0] - before[0] == pytest.approx(2.5 * 0.04)
    assert sim.getJointPosition(joints[0]) == pytest.approx(2.5)
    sim.stopSimulation(True)
    assert sim.getObjectPosition(body) == before
    assert sim.getSimulationState() == sim.simulation_stopped


def test_picture_is_rgb_with_the_lowest_row_first(sim: Any) -> None:
    camera = sim.getObject("/bubbleRob/visionSensor")
    assert sim.getVisionSensorImg(camera)[0] == bytes(256 * 256 * 3)
    sim.setObjectPosition(sim.getObject("/ball"), [0.8, 0.15, 0.3])
    sim.setStepping(True)
    sim.startSimulation()
    sim.step()
    pixels, size = sim.getVisionSensorImg(camera)
    picture = np.frombuffer(pixels, np.uint8).reshape(*reversed(size), 3).astype(int)
    rows, columns = np.nonzero(picture[..., 1] > picture[..., [0, 2]].max(axis=2) + 30)
    assert rows.mean() > 140  # the ball is above the camera
    assert columns.mean() < 110  # and on its left


def test_picture_is_shown_on_another_sensor(sim: Any) -> None:
    screen = sim.getObject("/v1")
    picture = bytes(range(256)) * (256 * 3)
    sim.setVisionSensorImg(screen, picture)
    assert sim.getVisionSensorImg(screen) == (picture, [256, 256])


def test_detected_point_is_in_the_frame_of_the_nose(sim: Any) -> None:
    nose = sim.getObject("/bubbleRob/sensingNose")
    sim.setStepping(True)
    sim.startSimulation()
    sim.step()
    assert sim.readProximitySensor(nose) == (0, 0.0, [0.0] * 3, -1, [0.0] * 3)
    ball = sim.getObject("/ball")
    sim.setObjectPosition(ball, [0.35, 0.03, 0.12])
    state, distance, point, seen, normal = sim.readProximitySensor(nose)
    assert (state, seen) == (1, ball)
    assert distance == pytest.approx(np.linalg.norm(point))
    assert point[0] > 0.0  # its x is to the left
    assert point[2] == pytest.approx(0.15, abs=0.01)
    assert normal[2] < -0.9


def test_errors_have_the_servers_words(sim: Any) -> None:
    with pytest.raises(Exception, match=r"^1254: in sim\._getObject: object does not exist"):
        sim.getObject("/unknown")
    with pytest.raises(Exception, match=r"^354: in sim\.setJointTargetVelocity: object is not a joint"):
        sim.setJointTargetVelocity(sim.getObject("/ball"), 1.0)


def test_lua_uses_the_same_scene(sim: Any) -> None:
    text = "sim=require'sim' function where(p) return sim.getObjectPosition(sim.getObject(p)),{a={},b={1,2}},nil,1 end"
    script = sim.createScript(sim.scripttype_customization, text)
    sim.initScript(script)
    place = sim.getObjectPosition(sim.getObject("/ball"))
    assert sim.callScriptFunction("where", script, "/ball") == (place, {"a": {}, "b": [1, 2]}, None, 1)
