"""Device drivers without hardware: one that records opening and closing, and one on a board with pins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import EntryPoint
from typing import Annotated, Any, ClassVar

import pytest
from pydantic import Field

from robotcore import plugins as registry
from robotcore.description import DeviceDescription, RobotDescription, StrictModel, load_robot
from robotcore.errors import DeviceError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.device import Device
from robotcore.hal.wiring import Pad, PadKind, Wiring
from robotcore.hardware import Connection, DeviceBinding, DeviceContext, DeviceDriver, Drivers, HardwareBackend
from robotcore.kinds.motor import MotorDescription


class RecordedDevice(Device):
    """A device that records its closing."""

    def __init__(self, name: str, calls: list[str]) -> None:
        super().__init__(name)
        self._calls = calls

    def _release(self) -> None:
        self._calls.append(f"close {self.name}")


class RecordingDriver(DeviceDriver):
    """Opens any device except those named in ``dead``, and records the calls."""

    name = "recording"
    summary = "for tests"
    described = StrictModel

    dead: tuple[str, ...] = ()
    calls: list[str] = Field(default_factory=list)

    def open(self, description: DeviceDescription, context: DeviceContext) -> Device:
        self.calls.append(f"open {description.name} beside {', '.join(context.opened) or 'nothing'}")
        if description.name in self.dead:
            raise DeviceError(description.name, "does not answer")
        return RecordedDevice(description.name, self.calls)


def bind(driver: RecordingDriver, robot: RobotDescription) -> list[DeviceBinding]:
    return [DeviceBinding(description, driver) for description in robot.devices]


def context(opened: dict[str, Device]) -> DeviceContext:
    return DeviceContext(load_robot("rover"), SteppedClock(20, lambda _steps: None), opened=opened)


class Plug(DeviceDriver):
    """A driver for any device. Several devices can share a ``bus``, but not a ``pin``."""

    name = "plug"
    summary = "for tests"
    described: ClassVar[type[StrictModel]] = StrictModel
    aliases = ("banana", "jack-42")

    pin: Annotated[int, Field(ge=1, le=9, description="the number of a hole, 1 to 9")]
    spare: int | None = None
    bus: int | None = None

    def open(self, description: Any, context: DeviceContext) -> Device:
        raise NotImplementedError

    def check(self, description: Any, robot: RobotDescription, drivers: Drivers) -> None:
        if self.pin == 9:
            raise ValueError("hole 9 is blocked; take another hole")

    def connections(self) -> Sequence[Connection]:
        wires = [Connection("pin", "hole", str(self.pin))]
        wires += [Connection("spare", "hole", str(self.spare))] if self.spare else []
        wires += [Connection("bus", "rail", str(self.bus), is_shared=True)] if self.bus else []
        return wires

    def notes(self, description: Any) -> Sequence[str]:
        return ("Push it in all the way.",)


class MotorPlug(Plug):
    """A driver for motors only."""

    name = "motor-plug"
    described = MotorDescription


class PlugBoard(HardwareBackend):
    """A board with nine holes. Its wiring shows two pads."""

    name = section = "plugboard"
    summary = "for tests"

    def wiring(self, robot: RobotDescription) -> Wiring:
        wiring = super().wiring(robot)
        pads = (Pad(1, "GPIO 1", PadKind.SIGNAL), Pad(2, "ground", PadKind.GROUND))
        return Wiring(pads, [replace(wire, pads=(int(wire.where[-1]),)) for wire in wiring.wires], wiring.notes)


def register(monkeypatch: pytest.MonkeyPatch, **broken: str) -> None:
    """Register the board and its drivers. ``broken`` maps the names of further drivers to their entry points."""
    drivers = {"plug": f"{__name__}:Plug", "motor-plug": f"{__name__}:MotorPlug", **broken}
    groups = (registry.APPS, registry.BACKENDS, registry.DEVICES, registry.FAULTS, registry.KINDS)
    points = {group: dict(registry._points(group)) for group in groups}
    points[registry.DEVICES] = {name: EntryPoint(name, value, registry.DEVICES) for name, value in drivers.items()}
    points[registry.BACKENDS]["plugboard"] = EntryPoint("plugboard", f"{__name__}:PlugBoard", registry.BACKENDS)
    monkeypatch.setattr("robotcore.plugins._points", points.get)


def robot_file(section: str) -> str:
    """Return a robot's file with a motor, a camera, a display, and ``section`` at its end."""
    body = "length_m = 0.2\nwidth_m = 0.2\nheight_m = 0.1\nclearance_m = 0.01\nmass_kg = 1.0\n"
    eye = "mount = { z_m = 0.1 }\nwidth_px = 320\nheight_px = 240\nhorizontal_fov_rad = 1.0\n"
    return (
        f'name = "post"\n[body]\n{body}\n'
        '[[devices]]\nkind = "motor"\nname = "neck"\nmax_velocity_rad_s = 1.0\n'
        f'[[devices]]\nkind = "camera"\nname = "eye"\n{eye}'
        f'[[devices]]\nkind = "display"\nname = "screen"\n{section}'
    )


NECK = '[plugboard.neck]\ndriver = "motor-plug"\npin = 1\n'
EYE = '[plugboard.eye]\ndriver = "plug"\npin = 2\n'
