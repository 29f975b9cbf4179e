"""The client of the simulator. As in vendors' clients, a call waits for its answer without a time limit."""

from __future__ import annotations

from multiprocessing.connection import Client, Connection
from pathlib import Path
from threading import Lock
from typing import Any

from robotcore.description import (
    AnyDevice,
    CameraDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    StrictModel,
)
from robotcore.geometry import Pose, Twist
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Angle, Camera, Device, Encoder, Frame, MemoryDisplay, Motor, Range, RangeSensor
from robotcore.hal.robot import Robot


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


class ExternalRange(RangeSensor):
    def __init__(self, answer: RangeSensorDescription, client: RpcClient) -> None:
        super().__init__(answer.name, min_range=answer.min_range_m, max_range=answer.max_range_m, cone=answer.cone_rad)
        self._client = client

    def _newest(self) -> Range:
        reading: Range = self._client.call("read", self.name)
        return reading


class ExternalCamera(Camera):
    def __init__(self, description: CameraDescription, client: RpcClient) -> None:
        super().__init__(description.name, description.intrinsics)
        self._client = client

    def _newest(self) -> Frame:
        frame: Frame = self._client.call("read", self.name)
        frame.image.flags.writeable = False
        return frame


class ExternalEncoder(Encoder):
    def __init__(self, description: EncoderDescription, client: RpcClient) -> None:
        super().__init__(description.name)
        self._client = client

    def _newest(self) -> Angle:
        angle: Angle = self._client.call("read", self.name)
        return angle


class ExternalTruth:
    def __init__(self, client: RpcClient) -> None:
        self._client = client

    def pose(self) -> Pose:
        pose: Pose = self._client.call("read_truth", "pose")
        return pose

    def twist(self) -> Twist:
        twist: Twist = self._client.call("read_truth", "twist")
        return twist

    def contacts(self) -> int:
        contacts: int = self._client.call("read_truth", "contacts")
        return contacts


def register(directory: Path) -> None:
    """Register this backend, as an installed package does, for processes with the directory on their path."""
    package = directory / "external_simulator-0.1.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: external-simulator\nVersion: 0.1\n")
    (package / "entry_points.txt").write_text(f"[robotcore.backends]\nexternal = {__name__}:ExternalSimulatorBackend\n")


def _open_device(description: AnyDevice, client: RpcClient) -> Device:
    match description:
        case MotorDescription():
            return ExternalMotor(description, client)
        case RangeSensorDescription():
            return ExternalRange(description, client)
        case CameraDescription():
            return ExternalCamera(description, client)
        case EncoderDescription():
            return ExternalEncoder(description, client)
    return MemoryDisplay(description.name)
