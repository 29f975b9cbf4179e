"""The client's side, as naive as vendors' clients are: a call waits for its answer for as long as it takes."""

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
    """Where the simulator listens."""

    port: int


class FarawayBackend(Backend):
    """Opens robots in the simulator of `tests.faraway.server`; ``wire`` is the connection of the last one."""

    name = "faraway"
    summary = "the built-in simulator, behind a socket"
    capabilities = frozenset({Capability.CONTACTS, Capability.POSE, Capability.LOCKSTEP})
    needs_world = True
    wire: Wire

    def open(self, setup: Setup) -> Robot:
        port = setup.options_as(FarawayOptions).port
        self.wire = wire = Wire(Client(("127.0.0.1", port)))
        wire.connection.send(setup)
        clock = SteppedClock(setup.rate_hz, lambda steps: wire.ask("advance", steps))
        devices = [_opened(description, wire) for description in setup.chosen]
        return Robot(setup.robot.name, clock, devices, truth=FarTruth(wire), release=wire.close)


class Wire:
    """The connection; one asks at a time. ``asked`` is all that was, whether or not an answer came."""

    def __init__(self, connection: Connection[Any, Any]) -> None:
        self.connection = connection
        self.asked: list[tuple[Any, ...]] = []
        self._lock = Lock()

    def ask(self, *what: Any) -> Any:
        self.asked.append(what)
        with self._lock:
            self.connection.send(what)
            return self.connection.recv()

    def close(self) -> None:
        self.connection.close()


class FarMotor(Motor):
    def __init__(self, description: MotorDescription, wire: Wire) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._wire = wire

    def _apply(self, rad_s: float) -> None:
        self._wire.ask("turn", self.name, rad_s)


class FarRange(RangeSensor):
    def __init__(self, answer: RangeSensorDescription, wire: Wire) -> None:
        super().__init__(answer.name, min_range=answer.min_range_m, max_range=answer.max_range_m, cone=answer.cone_rad)
        self._wire = wire

    def _newest(self) -> Range:
        reading: Range = self._wire.ask("read", self.name)
        return reading


class FarCamera(Camera):
    def __init__(self, description: CameraDescription, wire: Wire) -> None:
        super().__init__(description.name, description.intrinsics)
        self._wire = wire

    def _newest(self) -> Frame:
        frame: Frame = self._wire.ask("read", self.name)
        frame.image.flags.writeable = False
        return frame


class FarEncoder(Encoder):
    def __init__(self, description: EncoderDescription, wire: Wire) -> None:
        super().__init__(description.name)
        self._wire = wire

    def _newest(self) -> Angle:
        angle: Angle = self._wire.ask("read", self.name)
        return angle


class FarTruth:
    def __init__(self, wire: Wire) -> None:
        self._wire = wire

    def pose(self) -> Pose:
        pose: Pose = self._wire.ask("tell", "pose")
        return pose

    def twist(self) -> Twist:
        twist: Twist = self._wire.ask("tell", "twist")
        return twist

    def contacts(self) -> int:
        contacts: int = self._wire.ask("tell", "contacts")
        return contacts


def register(directory: Path) -> None:
    """Let whoever has the directory on its path find this backend, as an installed package's is found."""
    package = directory / "faraway-0.1.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: faraway\nVersion: 0.1\n")
    (package / "entry_points.txt").write_text("[robotcore.backends]\nfaraway = tests.faraway.backend:FarawayBackend\n")


def _opened(description: AnyDevice, wire: Wire) -> Device:
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
