"""The cycle of a robot, written by hand for each remote API, with the same requests as the backend's."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import cv2
import numpy as np
from coppeliasim_zmqremoteapi_client import RemoteAPIClient

from benchmarks.remote.cycles import DEVICES, Cycle, iterate_speeds
from drivers.vrep.wire import requests
from drivers.vrep.wire.message_socket import MessageSocket
from drivers.vrep.wire.requests import Request
from robotcore.hal.backend import Setup, load_backend

LONG_S = 10.0


@contextmanager
def open_client_cycle(setup: Setup) -> Iterator[Cycle]:
    """Open a cycle that calls CoppeliaSim's own client. Only the scene is built by the backend."""
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
    turns, distance = iterate_speeds(), partial(_choose_distance(sim, nose), sim, nose)
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
    """Return the function that reads the range sensor, a proximity sensor or a depth camera.

    The backend builds the one for which the simulator has a plug-in.
    """
    return _read_detection if sim.getObjectType(nose) == sim.sceneobject_proximitysensor else _read_deep


def _read_detection(sim: Any, nose: int) -> object:
    is_detected, _, point, *_ = sim.handleProximitySensor(nose)
    return np.linalg.norm(point) if is_detected == 1 else np.inf


def _read_deep(sim: Any, nose: int) -> object:
    sim.handleVisionSensor(nose)
    depths, _ = sim.getVisionSensorDepth(nose, 1)
    return np.frombuffer(depths, np.float32).min()


@contextmanager
def open_message_cycle(setup: Setup) -> Iterator[Cycle]:
    """Open a cycle that sends messages of the legacy remote API, in a scene that contains the rover."""
    with MessageSocket.open(str(setup.options["host"]), int(setup.options["port"]), LONG_S) as connection:
        legacy = _LegacyConnection(connection)
        legacy.ask(requests.SYNCHRONOUS_ON)
        legacy.ask(requests.START)
        handles = [legacy.ask(requests.object_handle(f"/rover/{name}"))[0] for name in DEVICES]
        yield _make_message_cycle(legacy, *handles)
        legacy.ask(requests.STOP)
        while legacy.is_running:
            legacy.ask(requests.CLOCK)


def _make_message_cycle(legacy: _LegacyConnection, left: int, right: int, nose: int, eye: int) -> Cycle:
    turns = iterate_speeds()
    places = requests.object_position(left), requests.object_position(right)
    reads = (*places, requests.proximity(nose), requests.colour_image(eye))

    def cycle() -> object:
        forward, backward = next(turns)
        moved = requests.joint_target_velocity(left, forward), requests.joint_target_velocity(right, backward)
        legacy.exchange(*moved, requests.TRIGGER)
        _, _, seen, pixels = legacy.ask(*reads)
        return np.linalg.norm(seen.point), _flip(pixels, pixels.shape[1], pixels.shape[0])

    return cycle


class _LegacyConnection:
    """A connection to the legacy remote API. It numbers the messages, and stores whether the simulation runs."""

    def __init__(self, connection: MessageSocket) -> None:
        self._socket, self._number = connection, 0
        self.is_running = False

    def exchange(self, *requests: Request[Any]) -> dict[tuple[int, bytes], Any]:
        """Send a message. Return the answers that the server's next message contains."""
        self._number += 1
        server, pieces = self._socket.exchange(self._number, [request.encode() for request in requests])
        self.is_running = server.is_running
        return {(piece.command, piece.key): piece for piece in pieces}

    def ask(self, *requests: Request[Any]) -> list[Any]:
        """Send requests, and return their answers. After a trigger, the answers are of the end of the step."""
        found = self.exchange(*requests)
        while not all(request.identity in found for request in requests):
            found |= self.exchange()
        return [request.read(found[request.identity]) for request in requests]


def _flip(pixels: Any, width: int, height: int) -> Any:
    """Return the simulator's pixels as a picture in BGR, whose first row is the top."""
    rgb = np.frombuffer(pixels, np.uint8).reshape(height, width, 3)
    return cv2.cvtColor(cv2.flip(rgb, 0), cv2.COLOR_RGB2BGR)
