"""The client of the simulator. Like many vendors' clients, a call waits for its answer without a time limit."""

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


class FarawayOptions(StrictModel):
    """The options of the backend."""

    port: int
    """The port of the simulator."""


class FarawayBackend(Backend):
    """Opens robots in the simulator of `tests.faraway.server`."""

    name = "faraway"
    summary = "the built-in simulator, behind a socket"
    capabilities = frozenset({Capability.CONTACTS, Capability.POSE, Capability.LOCKSTEP})
    needs_world = True
    wire: Wire
    """The connection of the last opened robot."""

    def open(self, setup: Setup) -> Robot:
        port = setup.options_as(FarawayOptions).port
        self.wire = wire = Wire(Client(("127.0.0.1", port)))
        wire.connection.send(setup)
        clock = SteppedClock(setup.rate_hz, lambda steps: wire.call("advance", steps))
        devices = [_open_device(description, wire) for description in setup.chosen]
        return Robot(setup.robot.name, clock, devices, truth=FarTruth(wire), release=wire.close)


class Wire:
    """The connection. Only one thread at a time sends a request."""

    def __init__(self, connection: Connection[Any, Any]) -> None:
        self.connection = connection
        self.requests: list[tuple[Any, ...]] = []
        """All requests, also those without an answer."""
        self._lock = Lock()

    def call(self, *request: Any) -> Any:
        self.requests.append(request)
        with self._lock:
            self.connection.send(request)
            return self.connection.recv()

    def close(self) -> None:
        self.connection.close()


class FarMotor(Motor):
    def __init__(self, description: MotorDescription, wire: Wire) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._wire = wire

    def _apply(self, rad_s: float) -> None:
        self._wire.call("turn", self.name, rad_s)


class FarRange(RangeSensor):
    def __init__(self, description: RangeSensorDescription, wire: Wire) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)
        self._wire = wire

    def _newest(self) -> Range:
        reading: Range = self._wire.call("read", self.name)
        return reading


class FarCamera(Camera):
    def __init__(self, description: CameraDescription, wire: Wire) -> None:
        super().__init__(description.name, description.intrinsics)
        self._wire = wire

    def _newest(self) -> Frame:
        frame: Frame = self._wire.call("read", self.name)
        frame.image.flags.writeable = False
        return frame


class FarEncoder(Encoder):
    def __init__(self, description: EncoderDescription, wire: Wire) -> None:
        super().__init__(description.name)
        self._wire = wire

    def _newest(self) -> Angle:
        angle: Angle = self._wire.call("read", self.name)
        return angle


class FarTruth:
    def __init__(self, wire: Wire) -> None:
        self._wire = wire

    def pose(self) -> Pose:
        pose: Pose = self._wire.call("truth", "pose")
        return pose

    def twist(self) -> Twist:
        twist: Twist = self._wire.call("truth", "twist")
        return twist

    def contacts(self) -> int:
        contacts: int = self._wire.call("truth", "contacts")
        return contacts


def register(directory: Path) -> None:
    """Write the metadata of an installed package, so that a process with the directory on its path has this backend."""
    package = directory / "faraway-0.1.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: faraway\nVersion: 0.1\n")
    (package / "entry_points.txt").write_text("[robotcore.backends]\nfaraway = tests.faraway.backend:FarawayBackend\n")


def _open_device(description: AnyDevice, wire: Wire) -> Device:
    match description:
        case MotorDescription():
            return FarMotor(description, wire)
        case RangeSensorDescription():
            return FarRange(description, wire)
        case CameraDescription():
            return FarCamera(description, wire)
        case EncoderDescription():
            return FarEncoder(description, wire)
    return MemoryDisplay(description.name)
