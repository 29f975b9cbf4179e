"""The cycle written by hand for either remote API, with the same requests as the framework's."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import cv2
import numpy as np
from coppeliasim_zmqremoteapi_client import RemoteAPIClient

from benchmarks.remote.cycles import DEVICES, Cycle, speeds
from drivers.vrep.wire import requests
from drivers.vrep.wire.message_socket import MessageSocket
from drivers.vrep.wire.requests import Request
from robotcore.hal.backend import Setup, load_backend

LONG_S = 10.0


@contextmanager
def plain_calls(setup: Setup) -> Iterator[Cycle]:
    """The calls of CoppeliaSim's own client; only the scene is built by the driver."""
    options = {**setup.options, "keep": True}
    with load_backend("coppeliasim").open(replace(setup, options=options)):
        pass
    sim = RemoteAPIClient(*setup.options.values()).require("sim")
    sim.setStepping(True)
    sim.startSimulation()
    try:
        sim.step()
        yield _make_call_cycle(sim)
    finally:
        sim.stopSimulation(True)


def _make_call_cycle(sim: Any) -> Cycle:
    rover = sim.getObject("/rover")
    left, right, nose, eye = (sim.getObject(f"/rover/{name}") for name in DEVICES)
    turns, distance = speeds(), partial(_choose_distance(sim, nose), sim, nose)
    for sensor in (nose, eye):
        sim.setExplicitHandling(sensor, 1)  # a scene that is kept has them handled by its main script

    def cycle() -> object:
        forward, backward = next(turns)
        sim.setJointTargetVelocity(left, forward)
        sim.setJointTargetVelocity(right, backward)
        sim.step()
        sim.getSimulationTime()
        sim.getContactInfo(sim.handle_all, rover, 0)
        near = distance()
        sim.handleVisionSensor(eye)
        pixels, (width, height) = sim.getVisionSensorImg(eye)
        return near, _flip(pixels, width, height)

    return cycle


def _choose_distance(sim: Any, nose: int) -> Callable[[Any, int], object]:
    """Return how it is measured: the driver builds what the simulator has a plug-in for."""
    return _read_detection if sim.getObjectType(nose) == sim.sceneobject_proximitysensor else _read_deep


def _read_detection(sim: Any, nose: int) -> object:
    is_detected, _, point, *_ = sim.handleProximitySensor(nose)
    return np.linalg.norm(point) if is_detected == 1 else np.inf


def _read_deep(sim: Any, nose: int) -> object:
    sim.handleVisionSensor(nose)
    depths, _ = sim.getVisionSensorDepth(nose, 1)
    return np.frombuffer(depths, np.float32).min()


@contextmanager
def raw_messages(setup: Setup) -> Iterator[Cycle]:
    """The messages of the legacy remote API, one by one, in a scene that has the rover."""
    with MessageSocket.open(str(setup.options["host"]), int(setup.options["port"]), LONG_S) as connection:
        talk = _Talk(connection)
        talk.ask(requests.SYNCHRONOUS_ON)
        talk.ask(requests.START)
        handles = [talk.ask(requests.object_handle(f"/rover/{name}"))[0] for name in DEVICES]
        yield _make_message_cycle(talk, *handles)
        talk.ask(requests.STOP)
        while talk.is_running:
            talk.ask(requests.CLOCK)


def _make_message_cycle(talk: _Talk, left: int, right: int, nose: int, eye: int) -> Cycle:
    turns = speeds()
    places = requests.object_position(left), requests.object_position(right)
    reads = (*places, requests.proximity(nose), requests.colour_image(eye))

    def cycle() -> object:
        forward, backward = next(turns)
        moved = requests.joint_target_velocity(left, forward), requests.joint_target_velocity(right, backward)
        talk.exchange(*moved, requests.TRIGGER)
        _, _, seen, pixels = talk.ask(*reads)
        return np.linalg.norm(seen.point), _flip(pixels, pixels.shape[1], pixels.shape[0])

    return cycle


class _Talk:
    """Numbers the messages on a connection, and knows whether the simulation runs."""

    def __init__(self, connection: MessageSocket) -> None:
        self._socket, self._number = connection, 0
        self.is_running = False

    def exchange(self, *requests: Request[Any]) -> dict[tuple[int, bytes], Any]:
        """Send a message; return the answers that have come by then."""
        self._number += 1
        server, pieces = self._socket.exchange(self._number, [request.encode() for request in requests])
        self.is_running = server.is_running
        return {(piece.command, piece.key): piece for piece in pieces}

    def ask(self, *requests: Request[Any]) -> list[Any]:
        """Return what is answered; after a trigger, that is as of the end of the step."""
        found = self.exchange(*requests)
        while not all(request.identity in found for request in requests):
            found |= self.exchange()
        return [request.read(found[request.identity]) for request in requests]


def _flip(pixels: Any, width: int, height: int) -> Any:
    """Return pixels as a picture: BGR, with a top-left origin."""
    rgb = np.frombuffer(pixels, np.uint8).reshape(height, width, 3)
    return cv2.cvtColor(cv2.flip(rgb, 0), cv2.COLOR_RGB2BGR)
