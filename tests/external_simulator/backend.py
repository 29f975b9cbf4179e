"""The client of the simulator. As in vendors' clients, a call waits for its answer without a time limit."""

from __future__ import annotations

from multiprocessing.connection import Client, Connection
from pathlib import Path
from threading import Lock
from typing import Any

from robotcore.description import DeviceDescription, StrictModel
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.device import Device, Sensor
from robotcore.hal.robot import Robot
from robotcore.kinds.camera import Camera, CameraDescription
from robotcore.kinds.display import MemoryDisplay
from robotcore.kinds.encoder import Encoder, EncoderDescription
from robotcore.kinds.motor import Motor, MotorDescription
from robotcore.kinds.range_sensor import RangeSensor, RangeSensorDescription


class ExternalSimulatorOptions(StrictModel):
    """The TCP port of the simulator on this machine."""

    port: int


class ExternalSimulatorBackend(Backend):
    """Opens robots in the simulator of `tests.external_simulator.server`. ``client`` belongs to the last one."""

    name = "external"
    summary = "the built-in simulator, behind a socket"
    capabilities = frozenset({Capability.CONTACTS, Capability.POSE, Capability.LOCKSTEP})
    needs_world = True
    client: RpcClient

    def open(self, setup: Setup) -> Robot:
        port = setup.options_as(ExternalSimulatorOptions).port
        self.client = client = RpcClient(Client(("127.0.0.1", port)))
        client.connection.send(setup)
        clock = SteppedClock(setup.rate_hz, lambda steps: client.call("advance", steps))
        devices = [_open_device(description, client) for description in setup.chosen_devices]
        return Robot(setup.robot.name, clock, devices, truth=ExternalTruth(client), release=client.close)


class RpcClient:
    """The connection. It sends one request at a time. ``requests`` are all requests, with or without an answer."""

    def __init__(self, connection: Connection[Any, Any]) -> None:
        self.connection = connection
        self.requests: list[tuple[Any, ...]] = []
        self._lock = Lock()

    def call(self, *request: Any) -> Any:
        self.requests.append(request)
        with self._lock:
            self.connection.send(request)
            return self.connection.recv()

    def close(self) -> None:
        self.connection.close()


class ExternalMotor(Motor):
    def __init__(self, description: MotorDescription, client: RpcClient) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._client = client

    def _apply(self, rad_s: float) -> None:
        self._client.call("turn", self.name, rad_s)


class RemoteReader(Sensor[Any]):
    """The base of sensors whose samples the server measures. ``client`` must be set."""

    client: RpcClient

    def _newest(self) -> Any:
        return self.client.call("read", self.name)


class ExternalRange(RemoteReader, RangeSensor):
    pass


class ExternalCamera(RemoteReader, Camera):
    pass


class ExternalEncoder(RemoteReader, Encoder):
    pass


class ExternalTruth:
    def __init__(self, client: RpcClient) -> None:
        self._client = client

    def pose(self) -> Any:
        return self._client.call("read_truth", "pose")

    def twist(self) -> Any:
        return self._client.call("read_truth", "twist")

    def contacts(self) -> Any:
        return self._client.call("read_truth", "contacts")


def register(directory: Path) -> None:
    """Register this backend, as an installed package does, for processes with the directory on their path."""
    package = directory / "external_simulator-0.1.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: external-simulator\nVersion: 0.1\n")
    (package / "entry_points.txt").write_text(f"[robotcore.backends]\nexternal = {__name__}:ExternalSimulatorBackend\n")


def _open_device(description: DeviceDescription, client: RpcClient) -> Device:
    sensor: RemoteReader
    match description:
        case MotorDescription():
            return ExternalMotor(description, client)
        case RangeSensorDescription(min_range_m=least, max_range_m=most):
            sensor = ExternalRange(description.name, min_range=least, max_range=most, cone=description.cone_rad)
        case CameraDescription():
            sensor = ExternalCamera(description.name, description.intrinsics)
        case EncoderDescription():
            sensor = ExternalEncoder(description.name)
        case _:
            return MemoryDisplay(description.name)
    sensor.client = client
    return sensor
